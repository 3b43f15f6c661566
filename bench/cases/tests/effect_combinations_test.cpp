// Any two effects of the registry run together on a small scene, whatever order they are named in; one that is not
// named leaves no trace.
#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "bench/cases/tests/combination_scene.hpp"
#include "core/effects/effect_registry.hpp"

namespace musclebench {
namespace {

RunResult run_of(const Scene& scene) {
  RunCase run = combination_case(scene);
  run.snapshots = {scene.loop.frames};
  return run_case(run, [](int /*frames*/) {});
}

RunResult run_with(const std::vector<std::string>& effects) { return run_of(combination_scene(effects)); }

/// The names in the profile.
std::vector<std::string> profile(const RunResult& result) {
  std::vector<std::string> names = result.effect_names;
  names.insert(names.end(), result.stage_names.begin(), result.stage_names.end());
  std::ranges::sort(names);
  return names;
}

/// The same of those that were named; a response is in the response's time.
std::vector<std::string> expected_profile(const std::vector<std::string>& effects) {
  std::vector<std::string> names = {"muscle_contact"};
  for (const std::string& effect : effects) {
    if (!find_effect(effect)->set_response) names.push_back(effect);
  }
  std::ranges::sort(names);
  return names;
}

void expect_sound(const RunResult& result, const std::vector<std::string>& effects) {
  const std::string named = fmt::format("{}", fmt::join(effects, " + "));
  EXPECT_TRUE(result.status == "ok" || result.status == "suspect") << named << ": " << result.status_detail;
  EXPECT_EQ(profile(result), expected_profile(effects)) << named;
  ASSERT_FALSE(result.snapshots.empty());
  for (const Vec3& position : result.snapshots.back().positions) {
    ASSERT_TRUE(position.allFinite() && position.norm() < 1) << named;
  }
}

TEST(EffectCombinations, EachAloneAndEveryPairRunsAndIsOfNoOrder) {
  const std::vector<EffectEntry>& entries = effect_registry();
  for (std::size_t i = 0; i < entries.size(); ++i) {
    expect_sound(run_with({entries[i].name}), {entries[i].name});
    for (std::size_t j = i + 1; j < entries.size(); ++j) {
      const std::vector<std::string> pair = {entries[i].name, entries[j].name};
      const RunResult result = run_with(pair);
      expect_sound(result, pair);
      EXPECT_EQ(run_with({pair[1], pair[0]}).state_hash, result.state_hash) << pair[0] << " + " << pair[1];
    }
  }
}

TEST(EffectCombinations, AllTogetherRun) {
  std::vector<std::string> all;
  for (const EffectEntry& entry : effect_registry()) all.push_back(entry.name);
  expect_sound(run_with(all), all);
}

/// A scene that could see any of them sees a difference: else the test of pairs would hold of effects that do nothing.
TEST(EffectCombinations, EachChangesTheState) {
  const std::string without = run_with({"gravity", "edge_length"}).state_hash;
  for (const EffectEntry& entry : effect_registry()) {
    if (entry.name == "gravity" || entry.name == "edge_length" || entry.name == "attachment") continue;
    const std::string with = run_with({"gravity", "edge_length", entry.name}).state_hash;
    if (entry.name == "fibre_force" || entry.name == "retinaculum") {  // whose scenes have one more table
      Scene bound = combination_scene({"gravity", "edge_length", entry.name});
      std::erase_if(bound.effects, [&](const SceneEffect& effect) { return effect.name == entry.name; });
      EXPECT_NE(with, run_of(bound).state_hash);
      continue;
    }
    // These act only where something would pass through a bone, is in two, or comes near its own muscle.
    const bool acts_rarely = entry.name == "tunnelling_guard" || entry.name == "multi_bone" ||
                             entry.name == "self_contact" || entry.name == "no_passage";
    if (!acts_rarely) {
      EXPECT_NE(with, without) << entry.name;
    }
  }
}

}  // namespace
}  // namespace musclebench

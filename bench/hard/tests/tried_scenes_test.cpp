// The search for effects beside what it does not do: every single addition, run to the end and judged in every frame.
#include <cstdlib>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "bench/cases/scene_source.hpp"
#include "bench/hard/fuzz_scene.hpp"
#include "bench/trials/effect_search.hpp"
#include "core/base/input_error.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/scene/check/auto_effects.hpp"

namespace musclebench {
namespace {

constexpr int tried_frames = 12;

std::string status_of(const Scene& scene) {
  const BackendEntry& backend = exact_backend();
  RunCase run{{scene, backend, Parameters(backend.parameters, {}, backend.name)}};
  run.colliders = choose_collider_backends({}, scene, backend);
  run.responses = choose_responses("", scene, backend, run.parameters, run.colliders);
  try {
    require_what_effects_need(scene, backend, run.parameters, run.responses, run.colliders);
    return run_case(run, [](int /*frames*/) {}).status;
  } catch (const InputError&) {
    return "refused";
  }
}

EffectTrial tried(const Scene& scene, const TrialRequest& request, const std::string& /*what*/) {
  return try_effects(scene, request, {});
}

/// Effects each of which alone makes the scene `ok`.
std::vector<std::string> mending_effects(const Scene& scene) {
  std::vector<std::string> mending;
  for (const EffectEntry& entry : effect_registry()) {
    if (entry.remedies.empty() || !may_add_effect(scene, entry.name)) continue;
    Scene with = scene;
    add_effect(with, {entry.name, entry.remedies.front().values}, "test", "");
    if (status_of(with) == "ok") mending.push_back(entry.name);
  }
  return mending;
}

/// What a search came to.
struct Searched {
  std::string before, after;  ///< status of a whole run
};

Searched expect_that_no_effect_is_missed(Scene& scene) {
  Searched searched{status_of(scene), ""};
  if (searched.before == "refused") return searched;
  const EffectChoice choice = choose_effects(scene, tried);
  searched.after = status_of(scene);
  EXPECT_FALSE(searched.before == "ok" && searched.after != "ok") << "made worse";
  if (searched.after == "ok") return searched;
  EXPECT_FALSE(choice.holds()) << "called held, and is " << searched.after;
  const std::vector<std::string> missed = mending_effects(scene);
  EXPECT_TRUE(missed.empty()) << fmt::format("{}", fmt::join(missed, ", "));
  return searched;
}

/// Hard scenes without the effects that mend them, but for those that keep a muscle whole.
class StrippedScene : public testing::TestWithParam<std::string> {};

TEST_P(StrippedScene, IsMended) {
  SceneChoice choice;
  choice.scene = "hard/" + GetParam();
  Scene scene = load_scene(choice);
  std::erase_if(scene.effects, [](const SceneEffect& effect) {
    const bool is_of_the_muscle = effect.name == "edge_length" || effect.name == "volume";
    return !find_effect(effect.name)->remedies.empty() && !is_of_the_muscle;
  });
  const Searched searched = expect_that_no_effect_is_missed(scene);
  EXPECT_EQ(searched.before, "suspect");
  EXPECT_EQ(searched.after, "ok");
}

// On a cliff contact of surfaces leaves a depth that the judge of a run cannot exclude.
INSTANTIATE_TEST_SUITE_P(Hard, StrippedScene,
                         testing::Values("crossed_bars", "on_cliff", "onto_needle", "over_hole", "press_shut"),
                         [](const auto& scene) { return scene.param; });

/// Takes minutes; asked for by .ci/weekly. MUSCLEBENCH_TRIED_SCENES: how many.
TEST(TriedScenes, DISABLED_NoSingleEffectWouldHaveMendedWhatStaysSuspect) {
  const char* asked = std::getenv("MUSCLEBENCH_TRIED_SCENES");
  const int scenes = asked == nullptr ? 40 : std::atoi(asked);
  int searched = 0;
  int mended = 0;
  int suspect = 0;
  for (std::uint64_t seed = 100; searched < scenes; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    FuzzScene random = fuzz_scene(seed, {exact_backend().name});
    random.loop["frames"] = std::int64_t{tried_frames};
    for (FuzzBody& bone : random.bones) bone.backend.clear();
    try {
      Scene scene = read_fuzz_scene(random);
      const Searched found = expect_that_no_effect_is_missed(scene);
      searched += found.before == "refused" ? 0 : 1;
      mended += found.before != "ok" && found.after == "ok" ? 1 : 0;
      suspect += found.after == "ok" || found.after.empty() ? 0 : 1;
    } catch (const InputError&) {
      // Not a scene.
    }
  }
  fmt::print("{} scenes: {} mended, {} still suspect or diverged\n", searched, mended, suspect);
}

}  // namespace
}  // namespace musclebench

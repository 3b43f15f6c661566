#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "bench/hard/hard_case.hpp"
#include "bench/hard/run_figures.hpp"
#include "bench/hard/tests/broken_backend.hpp"
#include "core/scene/scene.hpp"
#include "datasets/embedded/embedded_files.hpp"

namespace musclebench {
namespace {

std::vector<std::string> words_of(std::string_view text) {
  std::istringstream stream{std::string(text)};
  return {std::istream_iterator<std::string>(stream), {}};
}

/// Each effect has a scene that shows it alone.
std::set<std::string> all_effects() {
  constexpr std::string_view folder = "effects/";
  std::set<std::string> names;
  for (const EmbeddedFile& file : embedded_scenes()) {
    if (file.name.starts_with(folder)) names.emplace(file.name.substr(folder.size()));
  }
  return names;
}

/// Takes one effect out of a scene; that of contact with bones is the backend's.
void take_out(const std::string& effect, Scene& scene) {
  if (effect == "muscle_contact") scene.muscle_pairs.clear();
  if (effect == "fibre_anisotropy") {
    for (Muscle& muscle : scene.muscles) muscle.fibres.clear(), muscle.fibres_between_attachments = false;
  }
  if (effect == "attachment") scene.attachments.clear();
  std::erase_if(scene.effects, [&](const SceneEffect& each) { return each.name == effect; });
}

bool breaks_by_more(const HardCell& spoilt, const HardCell& usual) {
  if (spoilt.verdict == Verdict::not_applicable) return false;
  for (const HardFigure& figure : spoilt.figures) {
    const auto before = std::ranges::find(usual.figures, figure.name, &HardFigure::name);
    if (figure.holds()) continue;
    if (before == usual.figures.end()) {
      if (figure.name.ends_with("runs that diverge")) return true;
      continue;
    }
    if (before->holds() || (std::isnan(figure.value) && !std::isnan(before->value))) return true;
    if (figure.value > 1.1 * before->value) return true;
  }
  return false;
}

std::string told(const HardCell& cell) {
  std::string text = std::string(name_of(cell.verdict)) + "\n";
  for (const HardFigure& figure : cell.figures) {
    if (!figure.holds()) text += "  " + figure.name + ": " + std::to_string(figure.value) + "\n";
  }
  return text;
}

std::vector<HardCase> cases_with_loads() {
  std::vector<HardCase> cases = hard_cases();
  std::erase_if(cases, [](const HardCase& each) { return each.effects.empty(); });
  return cases;
}

TEST(LoadedEffects, EachHasAtLeastTwoCases) {
  const std::set<std::string> known = all_effects();
  EXPECT_EQ(known.size(), 20U);
  std::map<std::string, int> cases_of;
  for (const HardCase& each : hard_cases()) {
    std::set<std::string> seen;
    for (const std::string& effect : words_of(each.effects)) {
      EXPECT_TRUE(known.contains(effect)) << each.id << ": " << effect;
      EXPECT_TRUE(seen.insert(effect).second) << each.id << ": " << effect;
      ++cases_of[effect];
    }
  }
  for (const std::string& effect : known) EXPECT_GE(cases_of[effect], 2) << effect;
}

class LoadCase : public testing::TestWithParam<HardCase> {};

/// A case that nothing turns red tests nothing, and an effect that it can do without carries no load.
TEST_P(LoadCase, BreaksWithoutAnyOfItsEffects) {
  const HardCase& each = GetParam();
  const BackendEntry& backend = each.asks_backend ? exact_backend() : find_backend("null");
  const HardCell usual = each.run({.backend = backend});
  if (takes_too_long(usual)) GTEST_SKIP() << usual.detail;
  ASSERT_NE(usual.verdict, Verdict::not_applicable) << usual.detail;
  expect_sane_figures(each, usual);
  for (const std::string& effect : words_of(each.effects)) {
    const BackendEntry entry = effect == "contact" ? blind(backend) : backend;
    const HardCell spoilt = each.run({.backend = entry, .spoil = [&](Scene& scene) { take_out(effect, scene); }});
    if (takes_too_long(spoilt)) continue;
    EXPECT_TRUE(breaks_by_more(spoilt, usual))
        << each.id << " without " << effect << ": " << told(spoilt) << "and with it: " << told(usual);
  }
}

INSTANTIATE_TEST_SUITE_P(Hard, LoadCase, testing::ValuesIn(cases_with_loads()), [](const auto& each) {
  std::string name(each.param.id);
  std::ranges::replace(name, '-', '_');
  return name;
});

TEST(RunFigures, NoStatusExcusesAnotherRun) {
  const HardRequest of_field{.backend = find_backend("sdf")};
  MovedScene suspect;
  suspect.result.status = "suspect";
  RunFigures figures(of_field);
  figures.add_bare_run(suspect, "one", {{"f", 2, 1}});
  EXPECT_EQ(figures.judged().verdict, Verdict::refused);
  EXPECT_EQ(figures.judged().figures.front().name, "one: f");
  figures.add_bare_run(MovedScene{}, "other", {{"f", 0.5, 1}});
  EXPECT_EQ(figures.judged().verdict, Verdict::refused) << "what holds needs no excuse";
  figures.add_bare_run(MovedScene{}, "third", {{"f", 2, 1}});
  EXPECT_EQ(figures.judged().verdict, Verdict::breaks);
}

}  // namespace
}  // namespace musclebench

// The search for effects beside what it does not do: every single addition, run to the end and judged in every frame.
#include <algorithm>
#include <cstdlib>
#include <optional>
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
#include "datasets/embedded/embedded_files.hpp"

namespace musclebench {
namespace {

constexpr int tried_frames = 12;

/// Nothing where the scene is refused.
std::optional<RunResult> whole_run(const Scene& scene) {
  const BackendEntry& backend = exact_backend();
  RunCase run{{scene, backend, Parameters(backend.parameters, {}, backend.name)}};
  run.colliders = choose_collider_backends({}, scene, backend);
  run.responses = choose_responses("", scene, backend, run.parameters, run.colliders);
  try {
    require_what_effects_need(scene, backend, run.parameters, run.responses, run.colliders);
    return run_case(run, [](int /*frames*/) {});
  } catch (const InputError&) {
    return std::nullopt;
  }
}

std::string status_of(const Scene& scene) {
  const std::optional<RunResult> run = whole_run(scene);
  return run ? run->status : "refused";
}

/// Whether a figure is beyond its limit by a tenth more than before.
bool is_worse(const Scene& scene, const RunResult& run, const RunResult& before) {
  const std::vector<RequiredFigure> known = figures_of_run(scene, before);
  return std::ranges::any_of(figures_of_run(scene, run), [&](const RequiredFigure& figure) {
    const RequiredFigure* same = find_figure(known, figure.requirement);
    return !figure.holds() && (same == nullptr || same->holds() || figure.excess() > 1.1 * same->excess());
  });
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
  std::string before, after;          ///< status of a whole run
  std::vector<std::string> needless;  ///< additions without any of which the run is no worse
};

/// Without the effect nothing is worse, and the shape at the end is the same.
bool is_needless(const AddedEffect& added, const Scene& scene, const RunResult& run) {
  Scene without = scene;
  remove_added(without, added.effect);
  const std::optional<RunResult> less = whole_run(without);
  if (!less || less->status != run.status || is_worse(without, *less, run)) return false;
  return largest_rms_distance(scene.bodies(), less->end_positions, run.end_positions).distance_m <=
         scene.wanted.surface_m;
}

Searched expect_that_no_effect_is_missed(Scene& scene) {
  Searched searched{status_of(scene), "", {}};
  if (searched.before == "refused") return searched;
  const EffectChoice choice = choose_effects(scene, tried);
  const std::optional<RunResult> run = whole_run(scene);
  searched.after = run ? run->status : "refused";
  EXPECT_FALSE(searched.before == "ok" && searched.after != "ok") << "made worse";
  for (const AddedEffect& added : choice.added) {
    if (run && is_needless(added, scene, *run)) searched.needless.push_back(added.effect);
  }
  if (searched.after == "ok") return searched;
  EXPECT_FALSE(choice.holds()) << "called held, and is " << searched.after;
  const std::vector<std::string> missed = mending_effects(scene);
  EXPECT_TRUE(missed.empty()) << fmt::format("{}", fmt::join(missed, ", "));
  return searched;
}

/// The scene of that name without the effects that mend it, but for those that keep a muscle whole.
Scene stripped_scene(const std::string& name) {
  SceneChoice choice;
  choice.scene = name;
  Scene scene = load_scene(choice);
  std::erase_if(scene.effects, [](const SceneEffect& effect) {
    const bool is_of_the_muscle = effect.name == "edge_length" || effect.name == "volume";
    return !find_effect(effect.name)->remedies.empty() && !is_of_the_muscle;
  });
  return scene;
}

TEST(TriedScenes, AnAdditionThatChangesNothingIsSeen) {
  const auto is_needless_in = [](const char* name, const char* effect) {
    Scene scene = stripped_scene(name);
    add_effect(scene, {effect, find_effect(effect)->remedies.front().values}, "test", "");
    return is_needless(scene.auto_effects.added.front(), scene, *whole_run(scene));
  };
  EXPECT_TRUE(is_needless_in("hard/rest", "self_contact"));
  EXPECT_FALSE(is_needless_in("hard/over_hole", "surface_contact"));
}

class StrippedScene : public testing::TestWithParam<std::string> {};

TEST_P(StrippedScene, IsMended) {
  Scene scene = stripped_scene("hard/" + GetParam());
  const Searched searched = expect_that_no_effect_is_missed(scene);
  EXPECT_EQ(searched.before, "suspect");
  EXPECT_EQ(searched.after, "ok");
  EXPECT_EQ(searched.needless, std::vector<std::string>());
}

// On a cliff contact of surfaces leaves a depth that the judge of a run cannot exclude.
INSTANTIATE_TEST_SUITE_P(Hard, StrippedScene,
                         testing::Values("crossed_bars", "on_cliff", "onto_needle", "over_hole", "press_shut"),
                         [](const auto& scene) { return scene.param; });

/// Every scene that shows an effect, and every hard one. Takes minutes; asked for by .ci/weekly.
TEST(TriedScenes, DISABLED_EveryStrippedSceneIsCalledRight) {
  int scenes = 0;
  int ok = 0;
  for (const EmbeddedFile& file : embedded_scenes()) {
    if (!file.name.starts_with("hard/") && !file.name.starts_with("effects/")) continue;
    SCOPED_TRACE(file.name);
    Scene scene = stripped_scene(std::string(file.name));
    const Searched found = expect_that_no_effect_is_missed(scene);
    if (found.before == "refused") continue;
    ++scenes;
    ok += found.after == "ok" ? 1 : 0;
    EXPECT_EQ(found.needless, std::vector<std::string>());
    fmt::print("{}: {}, then {}\n", file.name, found.before, found.after);
  }
  fmt::print("{} scenes: {} ok in the end\n", scenes, ok);
  EXPECT_GE(scenes, 69);
  EXPECT_GE(ok, 56);
}

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

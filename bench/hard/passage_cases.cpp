#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "bench/hard/loaded_scene.hpp"
#include "bench/hard/run_figures.hpp"
#include "core/effects/effect_registry.hpp"

// What `no_passage` promises: at any speed nothing passes through anything.
namespace musclebench {

namespace {

void add_no_passage(Scene& scene) {
  const EffectEntry& entry = *find_effect("no_passage");
  scene.effects.push_back({.name = entry.name, .parameters = Parameters(entry.parameters, {}, "hard cases")});
}

void add_crossings(const MovedScene& run, const std::string& words, RunFigures& figures) {
  const Outcome& outcome = run.result.outcome;
  const auto number = [](const std::optional<int>& count) { return static_cast<double>(count.value_or(0)); };
  figures.add_bare_run(
      run, words,
      {{"triangles through bones", number(outcome.bone_crossings), 0, "triangles"},
       {"triangles through the muscle itself", number(outcome.self_intersecting_triangles), 0, "triangles"},
       {"triangles through other muscles", number(outcome.muscle_crossings), 0, "triangles"},
       {"nodes on the wrong side of a bone", static_cast<double>(outcome.tunnelled_nodes.value_or(0)), 0, "nodes"}});
}

/// A scene, the axis along which its muscles fly, their speed and for how many frames: long enough to be through.
struct Flight {
  const char* scene;
  int axis;
  double speed_m_per_s;
  std::int64_t frames;
};

/// Two muscles share the speed.
void add_flight(const HardRequest& request, const Flight& flight, RunFigures& figures) {
  Scene scene = load({std::string("hard/") + flight.scene, {{"frames", flight.frames}}});
  std::erase_if(scene.effects, [](const SceneEffect& effect) {
    return effect.name == "surface_contact" || effect.name == "tunnelling_guard";
  });
  scene.muscle_pairs.clear();
  add_no_passage(scene);
  const Vec3 velocity = flight.speed_m_per_s * Vec3::Unit(flight.axis);
  if (scene.muscles.size() == 1) {
    scene.muscles[0].velocity_m_per_s = -velocity;
  } else {
    scene.muscles[0].velocity_m_per_s = 0.5 * velocity;
    scene.muscles[1].velocity_m_per_s = -0.5 * velocity;
  }
  const std::string words = fmt::format("{} at {:g} m/s", flight.scene, flight.speed_m_per_s);
  // Each may take its time: what is squeezed flat takes as much as all others together.
  const MovedScene run = moved_in_time(request, std::move(scene), 1);
  if (!figures.add_if_diverged(run, words)) add_crossings(run, words, figures);
}

HardCell held_by_bones(const HardRequest& request) {
  constexpr std::array flights = {Flight{"onto_needle", 2, 1, 20}, Flight{"onto_needle", 2, 100, 5},
                                  Flight{"onto_ridge", 2, 10, 10}, Flight{"thrown_at_bone", 2, 100, 5}};
  return watched_runs(request, false, [&](RunFigures& figures) {
    for (const Flight& flight : flights) add_flight(request, flight, figures);
  });
}

HardCell held_by_muscles(const HardRequest& request) {
  constexpr std::array flights = {Flight{"crossed_bars", 2, 1, 12}, Flight{"crossed_bars", 2, 10, 3},
                                  Flight{"thrown_at_muscle", 0, 10, 20}, Flight{"thrown_at_muscle", 0, 100, 5}};
  return watched_runs(request, false, [&](RunFigures& figures) {
    for (const Flight& flight : flights) add_flight(request, flight, figures);
  });
}

constexpr auto squeezed_flat =
    "what stops within one step of up to 100 mm is squeezed flat, whatever keeps it from passing";

constexpr std::array cases_of_passage = {
    HardCase{.id = "no-passage-bones",
             .what = "A block flies onto a needle at 1 and 100 m/s and onto a ridge at 10 m/s. A ball flies at a plate "
                     "at 100 m/s.",
             .why = "A step is longer than the bone is thick, and needle and ridge meet no node (review 4, 5).",
             .bar = "no node and no triangle through the bone or through the muscle itself, in any frame",
             .scene = "hard/onto_needle",
             .left_out_because = squeezed_flat,
             .effects = "no_passage",
             .asks_backend = false,
             .run = held_by_bones},
    HardCase{.id = "no-passage-muscles",
             .what = "Two bars meet edge on edge at 1 and 10 m/s, and two balls fly into each other at 10 and 100 m/s.",
             .why = "Edges meet between nodes, and at 100 m/s the balls never overlap at the end of a step (review 3).",
             .bar = "no triangle through the other muscle or through its own, in any frame",
             .scene = "hard/crossed_bars",
             .left_out_because = squeezed_flat,
             .effects = "no_passage",
             .asks_backend = false,
             .run = held_by_muscles},
};

}  // namespace

std::span<const HardCase> passage_cases() { return cases_of_passage; }

}  // namespace musclebench

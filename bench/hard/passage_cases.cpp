#include <array>
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

HardCell held_by_bones(const HardRequest& request) {
  return watched_runs(request, false, [&](RunFigures& figures) {
    for (const std::string place : {"onto_needle", "onto_ridge", "thrown_at_bone"}) {
      for (const double speed_m_per_s : {1.0, 10.0, 100.0}) {
        Scene scene = load({"hard/" + place});
        std::erase_if(scene.effects, [](const SceneEffect& effect) {
          return effect.name == "surface_contact" || effect.name == "tunnelling_guard";
        });
        add_no_passage(scene);
        scene.muscles.front().velocity_m_per_s = Vec3(0, 0, -speed_m_per_s);
        const std::string words = fmt::format("{} at {:g} m/s", place, speed_m_per_s);
        const MovedScene run = moved_in_time(request, std::move(scene), 9);
        if (!figures.add_if_diverged(run, words)) add_crossings(run, words, figures);
      }
    }
  });
}

HardCell held_by_muscles(const HardRequest& request) {
  return watched_runs(request, false, [&](RunFigures& figures) {
    for (const auto& [place, axis] : {std::pair("crossed_bars", 2), {"thrown_at_muscle", 0}}) {
      for (const double speed_m_per_s : {1.0, 10.0, 100.0}) {
        Scene scene = load({std::string("hard/") + place});
        scene.muscle_pairs.clear();
        add_no_passage(scene);
        scene.muscles[0].velocity_m_per_s = 0.5 * speed_m_per_s * Vec3::Unit(axis);
        scene.muscles[1].velocity_m_per_s = -0.5 * speed_m_per_s * Vec3::Unit(axis);
        const std::string words = fmt::format("{} at {:g} m/s", place, speed_m_per_s);
        const MovedScene run = moved_in_time(request, std::move(scene), 6);
        if (!figures.add_if_diverged(run, words)) add_crossings(run, words, figures);
      }
    }
  });
}

constexpr auto squeezed_flat =
    "what stops within one step of up to 100 mm is squeezed flat, whatever keeps it from passing";

constexpr std::array cases_of_passage = {
    HardCase{.id = "no-passage-bones",
             .what = "A block flies onto a needle and onto a ridge, and a ball at a plate, at 1, 10 and 100 m/s.",
             .why = "A step is longer than the bone is thick, and needle and ridge meet no node (review 4, 5).",
             .bar = "no node and no triangle through the bone or through the muscle itself, in any frame",
             .scene = "hard/onto_needle",
             .left_out_because = squeezed_flat,
             .effects = "no_passage",
             .asks_backend = false,
             .run = held_by_bones},
    HardCase{.id = "no-passage-muscles",
             .what = "Two bars meet edge on edge, and two balls fly into each other, at 1, 10 and 100 m/s.",
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

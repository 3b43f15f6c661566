// What effects cost a frame, alone and together. All combinations start from rest and are timed in their second frame,
// where they have parted little: later, one effect changes how much another has to do.
#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "bench/cases/build_backend.hpp"
#include "bench/micro/micro_kernels.hpp"
#include "bench/micro/micro_scene.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/scene/effect_override.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {
namespace {

constexpr int rounds = 7;
constexpr int timed_frame = 2;

std::vector<std::string> all_effects() {
  std::vector<std::string> names;
  for (const EffectEntry& entry : effect_registry()) names.push_back(entry.name);
  return names;
}

Scene with_effects(const Scene& scene, const std::vector<std::string>& names) {
  Scene changed = scene;
  const std::vector<SceneEffect> own = changed.effects;
  std::erase_if(changed.effects,
                [&](const SceneEffect& effect) { return std::ranges::find(names, effect.name) == names.end(); });
  for (const std::string& name : names) {
    if (!has_effect(changed, name)) override_effects({{.location = "effects/", .name = name}}, changed.effects);
  }
  return changed;
}

/// A set of effects and the shortest time of its frame so far.
struct Combination {
  Scene scene;
  Nanoseconds shortest_ns = std::numeric_limits<Nanoseconds>::max();

  void time_once() {
    const BackendEntry& entry = exact_backend();
    const Case resolved{scene, entry, Parameters(entry.parameters, run_settings(entry.name), entry.name)};
    const BuiltBackend built = build_backend(resolved);
    const PreparedSimulation prepared = prepare_simulation(scene, *built.backend, resolved.responses, resolved.threads);
    for (int frame = 1; frame < timed_frame; ++frame) prepared.simulation->step_frame(frame);
    shortest_ns = std::min(shortest_ns, prepared.simulation->step_frame(timed_frame).frame_ns);
  }

  [[nodiscard]] double ms_above(const Combination& other) const {
    return 1e-6 * static_cast<double>(shortest_ns - other.shortest_ns);
  }
};

/// None, each alone, all; in turn, so that what slows the machine slows all alike.
void sum_of_parts(benchmark::State& state) {
  Scene scene = load_micro_scene("standard");
  scene.muscle_pairs.clear();
  const std::vector<std::string> names = all_effects();
  std::vector<Combination> combinations = {{with_effects(scene, {})}, {with_effects(scene, names)}};
  for (const std::string& name : names) combinations.push_back({with_effects(scene, {name})});
  for (auto _ : state) {
    for (int round = 0; round < rounds; ++round) {
      for (Combination& each : combinations) each.time_once();
    }
  }
  double sum_ms = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    state.counters[names[i]] = combinations[2 + i].ms_above(combinations[0]);
    sum_ms += combinations[2 + i].ms_above(combinations[0]);
  }
  const double all_ms = combinations[1].ms_above(combinations[0]);
  state.counters["all_ms"] = all_ms;
  state.counters["sum_ms"] = sum_ms;
  state.counters["all_over_sum"] = all_ms / sum_ms;
}

}  // namespace

void register_effect_kernels() {
  benchmark::RegisterBenchmark("effects/sum_of_parts", sum_of_parts)->Iterations(1)->Unit(benchmark::kMillisecond);
}

}  // namespace musclebench

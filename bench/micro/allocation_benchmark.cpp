// How often a frame after the second asks for heap memory, at most: a coupled run of each backend with each response
// that it can have, of those that promise none.
#include <algorithm>

#include <benchmark/benchmark.h>

#include "bench/cases/build_backend.hpp"
#include "bench/micro/micro_kernels.hpp"
#include "bench/micro/micro_scene.hpp"
#include "bench/process/heap_counter.hpp"
#include "core/base/input_error.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {
namespace {

constexpr int frames = 40;  // of the whole motion: contacts come and go fast

void allocations(benchmark::State& state, const std::string& name, ResponseKind response) {
  Scene scene = micro_scene();
  scene.loop.frames = frames;
  scene.muscle_pairs.clear();  // what a backend promises is about bones
  const BackendEntry& entry = find_backend(name);
  const Case resolved{scene, entry, Parameters(entry.parameters, run_settings(name), name), 1, 0, {response}};
  for (auto _ : state) {
    const BuiltBackend built = build_backend(resolved);
    const PreparedSimulation prepared =
        prepare_simulation(resolved.scene, *built.backend, resolved.responses, resolved.threads);
    std::uint64_t most = 0;
    for (int frame = 1; frame <= frames; ++frame) {
      const std::uint64_t before = heap_allocations();
      prepared.simulation->step_frame(frame);
      const std::uint64_t asked = heap_allocations() - before;
      most = frame > 2 ? std::max(most, asked) : 0;
    }
    state.counters["allocations"] = static_cast<double>(most);
  }
}

}  // namespace

void register_allocation_kernels() {
  for (const BackendEntry& entry : backend_registry()) {
    const Capabilities can = entry.make(Parameters(entry.parameters, {}, entry.name))->capabilities();
    for (const ResponseEntry& response : response_registry()) {
      if (can.steady_memory && lacks_for(response.kind, can).empty()) {
        benchmark::RegisterBenchmark(
            ("allocations/" + entry.name + "/" + response.name).c_str(),
            [name = entry.name, kind = response.kind](benchmark::State& s) { allocations(s, name, kind); })
            ->Iterations(1)
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
}

}  // namespace musclebench

// What a node of the distance field costs to build, with one thread and with two, and what fields weigh.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "backends/micro/point_kernels.hpp"
#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/micro/field_kernels.hpp"
#include "core/base/huge_pages.hpp"

namespace musclebench {
namespace {

void sdf_build_a_node(benchmark::State& state, const Bone& bone, int threads) {
  const SignedSurface surface(bone.surface);
  const GridShape shape = grid_over(bone.surface.mesh, {.cells = field_cells}, bone.name);
  move_to_huge_pages();
  for (auto _ : state) {
    const CubicField field = build_field(surface, shape, threads);
    benchmark::DoNotOptimize(field.bytes());
  }
  const auto nodes = static_cast<double>(shape.node_count());
  state.counters["ns_a_node"] =
      benchmark::Counter(nodes * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// Bytes of the field of 64 cells.
void sdf_bytes(benchmark::State& state, const Bone& bone) {
  const GridShape shape = grid_over(bone.surface.mesh, {.cells = field_cells}, bone.name);
  for (auto _ : state) {
    state.counters["bytes"] = static_cast<double>(build_field(SignedSurface(bone.surface), shape, 1).bytes());
  }
}

}  // namespace

void register_field_build_kernels(const Scene& scene) {
  for (const Bone& bone : scene.bones) {
    // By the time of the processor, as the queries that it is divided by.
    benchmark::RegisterBenchmark(fmt::format("sdf_build_a_node/{}", bone.name).c_str(), [&bone](benchmark::State& s) {
      sdf_build_a_node(s, bone, 1);
    })->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(
        fmt::format("sdf_build_threads/{}", bone.name).c_str(),
        [&bone](benchmark::State& s) { sdf_build_a_node(s, bone, static_cast<int>(s.range(0))); })
        ->Arg(1)
        ->Arg(2)
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
    benchmark::RegisterBenchmark(fmt::format("sdf_bytes/{}", bone.name).c_str(),
                                 [&bone](benchmark::State& s) { sdf_bytes(s, bone); })
        ->Iterations(1)
        ->Unit(benchmark::kMillisecond);
  }
}

}  // namespace musclebench

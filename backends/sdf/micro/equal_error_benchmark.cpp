// The adaptive distance field against the uniform one that errs as much: bytes and build time. Both are judged at the
// same points, which neither was built from.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <benchmark/benchmark.h>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/build/octree_builder.hpp"
#include "backends/sdf/build/reference_samples.hpp"
#include "backends/sdf/micro/field_kernels.hpp"
#include "core/base/huge_pages.hpp"
#include "core/base/percentile.hpp"
#include "core/base/scoped_timer.hpp"

namespace musclebench {
namespace {

constexpr double wanted_m = 5e-5;
constexpr std::size_t place_count = 20000;
constexpr double coarsest_m = 3e-3;
constexpr double finest_m = 0.5e-3;
constexpr double finer = 0.95;  // each uniform grid's cell over that before it

/// The error that 99 of 100 points stay below; where the field knows nothing it errs without bound.
template <typename Field>
double p99_error_m(const Field& field, const std::vector<ReferenceSample>& samples) {
  std::vector<double> errors;
  for (const ReferenceSample& sample : samples) {
    const auto value = field.value(sample.point);
    errors.push_back(value ? std::abs(*value - sample.distance_m) : std::numeric_limits<double>::infinity());
  }
  return percentile(std::move(errors), 0.99);
}

void adaptive_over_uniform(benchmark::State& state, const Bone& bone) {
  const SignedSurface surface(bone.surface);
  move_to_huge_pages();
  for (auto _ : state) {
    Nanoseconds adaptive_ns = 0;
    const OctreeField adaptive = [&] {
      const ScopedTimer timer(adaptive_ns);
      return build_octree(surface, bone.surface.mesh, {.max_error_m = wanted_m}, bone.name, 1);
    }();
    const std::vector<ReferenceSample> samples =
        reference_samples(surface, bone.surface.mesh, adaptive.quality().near_m, place_count, 11, 1);
    const double reached_m = p99_error_m(adaptive, samples);
    double cell_size_m = coarsest_m;
    double uniform_p99_m = std::numeric_limits<double>::infinity();
    double uniform_bytes = 0;
    Nanoseconds uniform_ns = 0;
    for (; uniform_p99_m > reached_m && cell_size_m > finest_m; cell_size_m *= finer) {
      uniform_ns = 0;
      const GridShape shape = grid_over(bone.surface.mesh, {.cell_size_m = cell_size_m}, bone.name);
      const CubicField uniform = [&] {
        const ScopedTimer timer(uniform_ns);
        return build_field(surface, shape, 1);
      }();
      uniform_p99_m = p99_error_m(uniform, samples);
      uniform_bytes = static_cast<double>(uniform.bytes());
    }
    state.counters["adaptive_p99_mm"] = reached_m * 1e3;
    state.counters["uniform_p99_mm"] = uniform_p99_m * 1e3;
    state.counters["uniform_cell_mm"] = cell_size_m / finer * 1e3;
    state.counters["adaptive_bytes"] = static_cast<double>(adaptive.bytes());
    state.counters["uniform_bytes"] = uniform_bytes;
    state.counters["adaptive_seconds"] = static_cast<double>(adaptive_ns) * 1e-9;
    state.counters["uniform_seconds"] = static_cast<double>(uniform_ns) * 1e-9;
    state.counters["bytes_ratio"] = static_cast<double>(adaptive.bytes()) / uniform_bytes;
    state.counters["build_ratio"] = static_cast<double>(adaptive_ns) / static_cast<double>(uniform_ns);
  }
}

}  // namespace

void register_equal_error_kernels(const Scene& scene) {
  for (const Bone& bone : scene.bones) {
    benchmark::RegisterBenchmark(("adaptive_over_uniform/" + bone.name).c_str(),
                                 [&bone](benchmark::State& s) { adaptive_over_uniform(s, bone); })
        ->Iterations(1)
        ->Unit(benchmark::kMillisecond);
  }
}

}  // namespace musclebench

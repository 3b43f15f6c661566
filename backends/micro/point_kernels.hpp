#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include <benchmark/benchmark.h>

#include "core/base/huge_pages.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// Along the longest side of a bone's box, of the grids whose building and queries are timed.
inline constexpr int field_cells = 64;
inline constexpr std::size_t point_count = 40000;
inline constexpr std::size_t batch_size = 256;

/// Points in the rest frame of `bone` where the queries of a run are: vertices of the muscle, moved at random by 2 mm
/// (standard deviation) in each direction, again and again until there are `count`, of which only those in the bone's
/// box are kept; empty where the muscle is nowhere near. The same in every call.
std::vector<Vec3> points_near(const Scene& scene, const Bone& bone, std::size_t count);

/// Points spread evenly over the bone's box, enlarged by a tenth.
std::vector<Vec3> points_far(const Bone& bone, std::size_t count);

/// Made when first asked for, and kept: one a bone.
template <typename Structure, typename Make>
const Structure& kept(std::map<const Bone*, std::unique_ptr<Structure>>& structures, const Bone& bone,
                      const Make& make) {
  std::unique_ptr<Structure>& structure = structures[&bone];
  if (structure == nullptr) {
    structure = std::make_unique<Structure>(make());
  }
  return *structure;
}

/// Kept, too.
const SignedSurface& surface_of(const Bone& bone);

/// Calls `query` with all points, `batch_size` at a time, again and again.
template <typename Query>
void ask_batches(benchmark::State& state, const std::vector<Vec3>& points, const Query& query) {
  if (points.empty()) {
    state.SkipWithError("the muscle is nowhere near this bone");
    return;
  }
  move_to_huge_pages();
  for (auto _ : state) {
    for (std::size_t first = 0; first < points.size(); first += batch_size) {
      query(std::span(points).subspan(first, std::min(batch_size, points.size() - first)));
    }
  }
  const auto asked = static_cast<double>(points.size()) * 1e-9;
  state.counters["ns_a_point"] =
      benchmark::Counter(asked, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["points"] = static_cast<double>(points.size());
}

/// The same point by point; `query` returns a number.
template <typename Query>
void ask(benchmark::State& state, const std::vector<Vec3>& points, const Query& query) {
  ask_batches(state, points, [&](std::span<const Vec3> batch) {
    double sum = 0;
    for (const Vec3& point : batch) {
      sum += query(point);
    }
    benchmark::DoNotOptimize(sum);
  });
}

}  // namespace musclebench

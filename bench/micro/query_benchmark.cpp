// What one query costs, without memory of any query before it: the voxel test, value and gradient of the distance
// field, the exact closest point with its sign. All on the same points, in the order of the muscle's vertices.
#include <algorithm>
#include <map>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/build/octree_builder.hpp"
#include "backends/voxel/voxel_grid.hpp"
#include "bench/micro/micro_kernels.hpp"
#include "bench/micro/micro_scene.hpp"
#include "core/base/huge_pages.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {
namespace {

constexpr std::size_t point_count = 40000;
constexpr std::size_t batch_size = 256;

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

const SignedSurface& surface_of(const Bone& bone) {
  static std::map<const Bone*, std::unique_ptr<SignedSurface>> surfaces;
  return kept(surfaces, bone, [&] { return SignedSurface(bone.surface); });
}

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

/// The same point by point.
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

/// As the backend does it: world to cells in one affine map, then one bit.
void voxel_test(benchmark::State& state, const Bone& bone) {
  const VoxelGrid grid(bone.surface.mesh, field_cells, 0, bone.name);
  const RigidMotion pose;
  const Vec3 per_cell = grid.cell_size_m().cwiseInverse();
  const Mat3 linear = per_cell.asDiagonal() * pose.rotation.transpose();
  const Vec3 offset = -(linear * pose.translation_m) - per_cell.cwiseProduct(grid.lower());
  ask(state, points_near(bone, point_count),
      [&](const Vec3& point) { return grid.contains_scaled(linear * point + offset) ? 1.0 : 0.0; });
}

/// As the backend does it: world to cells in one affine map, then value and gradient of all that are in the field.
void sdf_value_and_gradient(benchmark::State& state, const Bone& bone, FieldPrecision precision,
                            const std::vector<Vec3>& points) {
  static std::map<FieldPrecision, std::map<const Bone*, std::unique_ptr<CubicField>>> fields;
  const CubicField& field = kept(fields[precision], bone, [&] {
    const GridShape shape = grid_over(bone.surface.mesh, {.cells = field_cells}, bone.name);
    return build_field(surface_of(bone), shape, precision, 1);
  });
  const CellMap map(field.shape(), RigidMotion());
  std::vector<int> nodes(points.size());
  std::iota(nodes.begin(), nodes.end(), 0);
  FieldBlock block;
  ask_batches(state, points, [&](std::span<const Vec3> asked) {
    for (std::size_t next = 0; next < asked.size();) {
      block.count = 0;
      next = field.sample(map, asked, std::span(nodes).first(asked.size()), next, CubicField::Wanted::known, block);
      benchmark::DoNotOptimize(&block);
      benchmark::ClobberMemory();
    }
  });
}

/// The same of the adaptive field that errs by 0.05 mm.
void octree_value_and_gradient(benchmark::State& state, const Bone& bone, const std::vector<Vec3>& points) {
  static std::map<const Bone*, std::unique_ptr<OctreeField>> fields;
  const OctreeField& field =
      kept(fields, bone, [&] { return build_octree(surface_of(bone), bone.surface.mesh, {}, bone.name, 1); });
  const CellMap map(field.shape().grid(), RigidMotion());
  std::vector<int> nodes(points.size());
  std::iota(nodes.begin(), nodes.end(), 0);
  FieldBlock block;
  LeafBlock leaves;
  ask_batches(state, points, [&](std::span<const Vec3> asked) {
    for (std::size_t next = 0; next < asked.size();) {
      block.count = 0;
      next = field.sample(map, asked, std::span(nodes).first(asked.size()), next, block, leaves);
      benchmark::DoNotOptimize(&block);
      benchmark::ClobberMemory();
    }
  });
}

void bvh_locate(benchmark::State& state, const Bone& bone, const std::vector<Vec3>& points) {
  const SignedSurface& surface = surface_of(bone);
  ask(state, points, [&](const Vec3& point) { return surface.locate(point).signed_distance_m(); });
}

}  // namespace

void register_query_kernels() {
  const auto add = [](const std::string& name, auto kernel) {
    benchmark::RegisterBenchmark(name.c_str(), kernel)->Unit(benchmark::kMicrosecond);
  };
  for (const Bone& bone : micro_scene().bones) {
    add("voxel_test/" + bone.name, [&bone](benchmark::State& s) { voxel_test(s, bone); });
    for (const auto& [word, precision] :
         {std::pair("float", FieldPrecision::single_precision), std::pair("double", FieldPrecision::double_precision),
          std::pair("compact", FieldPrecision::compact)}) {
      add(fmt::format("sdf_value_and_gradient/{}/{}", word, bone.name), [&bone, p = precision](benchmark::State& s) {
        sdf_value_and_gradient(s, bone, p, points_near(bone, point_count));
      });
    }
    // One batch again and again, whose cells stay in the first cache: what is left is computing.
    add("sdf_value_and_gradient_in_cache/" + bone.name, [&bone](benchmark::State& s) {
      std::vector<Vec3> points = points_near(bone, point_count);
      points.resize(std::min(points.size(), batch_size));
      sdf_value_and_gradient(s, bone, FieldPrecision::single_precision, points);
    });
    add("octree_value_and_gradient/" + bone.name,
        [&bone](benchmark::State& s) { octree_value_and_gradient(s, bone, points_near(bone, point_count)); });
    add("octree_value_and_gradient_in_cache/" + bone.name, [&bone](benchmark::State& s) {
      std::vector<Vec3> points = points_near(bone, point_count);
      points.resize(std::min(points.size(), batch_size));
      octree_value_and_gradient(s, bone, points);
    });
    add("bvh_locate/near/" + bone.name,
        [&bone](benchmark::State& s) { bvh_locate(s, bone, points_near(bone, point_count)); });
    add("bvh_locate/far/" + bone.name,
        [&bone](benchmark::State& s) { bvh_locate(s, bone, points_far(bone, point_count)); });
  }
}

}  // namespace musclebench

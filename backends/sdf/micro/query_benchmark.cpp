// What one query of the distance field costs, value and gradient, without memory of any query before it.
#include <algorithm>
#include <map>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "backends/micro/point_kernels.hpp"
#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/build/octree_builder.hpp"
#include "backends/sdf/micro/field_kernels.hpp"

namespace musclebench {
namespace {

/// As the backend does it: world to cells in one affine map, then value and gradient of all that are in the field.
void sdf_value_and_gradient(benchmark::State& state, const Bone& bone, const std::vector<Vec3>& points) {
  static std::map<const Bone*, std::unique_ptr<CubicField>> fields;
  const CubicField& field = kept(fields, bone, [&] {
    const GridShape shape = grid_over(bone.surface.mesh, {.cells = field_cells}, bone.name);
    return build_field(surface_of(bone), shape, 1);
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

}  // namespace

void register_field_query_kernels(const Scene& scene) {
  const auto add = [](const std::string& name, auto kernel) {
    benchmark::RegisterBenchmark(name.c_str(), kernel)->Unit(benchmark::kMicrosecond);
  };
  for (const Bone& bone : scene.bones) {
    add("sdf_value_and_gradient/" + bone.name, [&scene, &bone](benchmark::State& s) {
      sdf_value_and_gradient(s, bone, points_near(scene, bone, point_count));
    });
    // One batch again and again, whose cells stay in the first cache: what is left is computing.
    add("sdf_value_and_gradient_in_cache/" + bone.name, [&scene, &bone](benchmark::State& s) {
      std::vector<Vec3> points = points_near(scene, bone, point_count);
      points.resize(std::min(points.size(), batch_size));
      sdf_value_and_gradient(s, bone, points);
    });
    add("octree_value_and_gradient/" + bone.name, [&scene, &bone](benchmark::State& s) {
      octree_value_and_gradient(s, bone, points_near(scene, bone, point_count));
    });
    add("octree_value_and_gradient_in_cache/" + bone.name, [&scene, &bone](benchmark::State& s) {
      std::vector<Vec3> points = points_near(scene, bone, point_count);
      points.resize(std::min(points.size(), batch_size));
      octree_value_and_gradient(s, bone, points);
    });
  }
}

}  // namespace musclebench

// What one voxel test costs, as the backend does it.
#include "backends/micro/point_kernels.hpp"
#include "backends/voxel/voxel_grid.hpp"

namespace musclebench {
namespace {

/// World to cells in one affine map, then one bit.
void voxel_test(benchmark::State& state, const Scene& scene, const Bone& bone) {
  const VoxelGrid grid(bone.surface.mesh, field_cells, 0, bone.name);
  const RigidMotion pose;
  const Vec3 per_cell = grid.cell_size_m().cwiseInverse();
  const Mat3 linear = per_cell.asDiagonal() * pose.rotation.transpose();
  const Vec3 offset = -(linear * pose.translation_m) - per_cell.cwiseProduct(grid.lower());
  ask(state, points_near(scene, bone, point_count),
      [&](const Vec3& point) { return grid.contains_scaled(linear * point + offset) ? 1.0 : 0.0; });
}

}  // namespace

/// `voxel_test/BONE`. `scene` outlives the kernels.
void register_voxel_kernels(const Scene& scene) {
  for (const Bone& bone : scene.bones) {
    benchmark::RegisterBenchmark(("voxel_test/" + bone.name).c_str(), [&scene, &bone](benchmark::State& s) {
      voxel_test(s, scene, bone);
    })->Unit(benchmark::kMicrosecond);
  }
}

}  // namespace musclebench

// What one voxel test costs, as the backend does it.
#include <algorithm>
#include <array>
#include <numeric>

#include "backends/micro/point_kernels.hpp"
#include "backends/voxel/voxel_kernel.hpp"

namespace musclebench {
namespace {

void voxel_test(benchmark::State& state, const Scene& scene, const Bone& bone) {
  const VoxelGrid grid(bone.surface.mesh, field_cells, 0, bone.name);
  const VoxelMap map(grid, RigidMotion{});
  std::array<int, batch_size> nodes{};
  std::iota(nodes.begin(), nodes.end(), 0);
  ask_batches(state, points_near(scene, bone, point_count), [&](std::span<const Vec3> points) {
    VoxelBlock block;
    for (std::size_t first = 0; first < points.size(); first += VoxelBlock::capacity) {
      const std::size_t count = std::min(VoxelBlock::capacity, points.size() - first);
      look_up(grid, map, points, std::span(nodes).subspan(first, count), block);
      benchmark::DoNotOptimize(block.in_set);
    }
  });
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

#include "core/scene/rest_overlap.hpp"

#include <algorithm>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

std::vector<RestOverlap> free_overlaps_at_rest(const Scene& scene) {
  const std::vector<Vec3>& nodes = scene.muscle_mesh.vertices;
  std::vector<char> is_free(nodes.size(), 1);
  for (const BoundNode& bound : scene.bound_nodes()) {
    is_free[static_cast<std::size_t>(bound.node)] = 0;
  }
  std::vector<RestOverlap> overlaps;
  for (const Bone& bone : scene.bones) {
    RestOverlap& overlap = overlaps.emplace_back();
    const Eigen::AlignedBox3d box = bounding_box(bone.surface.mesh.vertices);
    const double touching_m = touching_distance_m(bone.surface.mesh);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (is_free[i] == 0 || !box.contains(nodes[i]) || bone.tree().winding_number(nodes[i]) <= 0.5) {
        continue;
      }
      const double depth_m = bone.tree().closest_point(nodes[i])->distance_m;
      if (depth_m > touching_m) {
        ++overlap.nodes;
        overlap.deepest_m = std::max(overlap.deepest_m, depth_m);
      }
    }
  }
  return overlaps;
}

}  // namespace musclebench

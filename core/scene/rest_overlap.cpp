#include "core/scene/rest_overlap.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

void add_node(const Vec3& node, const Eigen::AlignedBox3d& box, const TriangleBvh& tree, double touching_m,
              RestOverlap& overlap) {
  if (!box.contains(node) || tree.winding_number(node) <= 0.5) {
    return;
  }
  const double depth_m = tree.closest_point(node)->distance_m;
  if (depth_m > touching_m) {
    ++overlap.nodes;
    overlap.deepest_m = std::max(overlap.deepest_m, depth_m);
  }
}

}  // namespace

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
      if (is_free[i] != 0) add_node(nodes[i], box, bone.tree(), touching_m, overlap);
    }
  }
  return overlaps;
}

std::vector<RestOverlap> muscle_overlaps_at_rest(const Scene& scene) {
  struct Surface {
    TriangleMesh mesh;
    TriangleBvh tree;
    Eigen::AlignedBox3d box;
  };
  std::vector<std::optional<Surface>> surfaces(scene.muscles.size());
  const auto surface_of = [&](int muscle) -> const Surface& {
    auto& surface = surfaces[static_cast<std::size_t>(muscle)];
    if (!surface) {
      TriangleMesh mesh = scene.mesh_of(scene.muscles[static_cast<std::size_t>(muscle)].body);
      TriangleBvh tree(mesh);
      const Eigen::AlignedBox3d box = bounding_box(mesh.vertices);
      surface.emplace(Surface{std::move(mesh), std::move(tree), box});
    }
    return *surface;
  };
  std::vector<RestOverlap> overlaps;
  for (const SceneMusclePair& pair : scene.muscle_pairs) {
    RestOverlap& overlap = overlaps.emplace_back();
    const Surface& first = surface_of(pair.muscles.first);
    const Surface& second = surface_of(pair.muscles.second);
    for (const auto& [of, in] : {std::pair(&first, &second), std::pair(&second, &first)}) {
      const double touching_m = touching_distance_m(in->mesh);
      for (const Vec3& node : of->mesh.vertices) add_node(node, in->box, in->tree, touching_m, overlap);
    }
  }
  return overlaps;
}

}  // namespace musclebench

#include "core/scene/rest_overlap.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/bvh/nearby_triangles.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/signed_distance/ray_winding.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

namespace {

void add_node(const Vec3& node, const Eigen::AlignedBox3d& box, const TriangleBvh& tree, double touching_m,
              RestOverlap& overlap) {
  ++overlap.of_nodes;
  if (!box.contains(node) || tree.winding_number(node) <= 0.5) {
    return;
  }
  const double depth_m = tree.closest_point(node)->distance_m;
  if (depth_m > touching_m) {
    ++overlap.nodes;
    overlap.deepest_m = std::max(overlap.deepest_m, depth_m);
  }
}

/// Those of `nodes` that are in the bone. The bone's tree is asked only where rays do not tell.
std::vector<Vec3> nodes_inside(const Bone& bone, const std::vector<Vec3>& nodes) {
  if (nodes.empty()) return {};
  const TriangleMesh& mesh = bone.surface.mesh;
  std::optional<RayWinding> rays;
  if (bone.surface.known_closed || is_closed(mesh)) rays.emplace(mesh, bounding_box(nodes));
  std::vector<Vec3> inside;
  for (const Vec3& node : nodes) {
    const std::optional<int> winding = rays ? rays->at(node) : std::nullopt;
    if (winding ? *winding > 0 : bone.tree().winding_number(node) > 0.5) inside.push_back(node);
  }
  return inside;
}

RestOverlap overlap_of(const Bone& bone, const std::vector<Vec3>& inside) {
  constexpr double usual_depth = 0.02;  // over the bone's diagonal; for what is deeper there is the bone's tree
  RestOverlap overlap;
  if (inside.empty()) return overlap;
  const TriangleMesh& mesh = bone.surface.mesh;
  const double touching_m = touching_distance_m(mesh);
  const NearbyTriangles nearby(mesh, inside, usual_depth * bounding_box(mesh.vertices).diagonal().norm());
  for (const Vec3& node : inside) {
    const auto near = nearby.closest_point(node, nearby.margin_m());
    const double depth_m = near ? near->distance_m : bone.tree().closest_point(node)->distance_m;
    if (!(depth_m > touching_m)) continue;
    ++overlap.nodes;
    overlap.deepest_m = std::max(overlap.deepest_m, depth_m);
  }
  return overlap;
}

std::vector<RestOverlap> overlaps_with_bones(const Scene& scene, bool of_bound_nodes) {
  const std::vector<Vec3>& nodes = scene.muscle_mesh.vertices;
  std::vector<char> is_bound(nodes.size(), 0);
  for (const BoundNode& bound : scene.bound_nodes()) {
    is_bound[static_cast<std::size_t>(bound.node)] = 1;
  }
  std::vector<RestOverlap> overlaps;
  for (const Bone& bone : scene.bones) {
    const Eigen::AlignedBox3d box = bounding_box(bone.surface.mesh.vertices);
    std::vector<Vec3> in_box;
    int of_nodes = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if ((is_bound[i] != 0) != of_bound_nodes) continue;
      ++of_nodes;
      if (box.contains(nodes[i])) in_box.push_back(nodes[i]);
    }
    overlaps.push_back(overlap_of(bone, nodes_inside(bone, in_box)));
    overlaps.back().of_nodes = of_nodes;
  }
  return overlaps;
}

}  // namespace

std::vector<RestOverlap> free_overlaps_at_rest(const Scene& scene) { return overlaps_with_bones(scene, false); }

std::vector<RestOverlap> attached_overlaps_at_rest(const Scene& scene) { return overlaps_with_bones(scene, true); }

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

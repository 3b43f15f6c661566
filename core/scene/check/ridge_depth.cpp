#include "core/scene/check/ridge_depth.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/base/percentile.hpp"

namespace musclebench {

namespace {

/// How far below the plane through `point` the surface lies at `point + beside`; negative above it. At most as far as
/// `beside` is long.
double drop_m(const TriangleBvh& bone, const Vec3& point, const Vec3& normal, const Vec3& beside,
              std::vector<PathCrossing>& crossings) {
  const double reach_m = beside.norm();
  const Vec3 above = point + beside + reach_m * normal;
  bone.find_crossings(above, above - 2 * reach_m * normal, crossings);
  if (crossings.empty()) return reach_m;
  const PathCrossing& first = crossings.front();
  return first.entering ? (2 * first.share - 1) * reach_m : -reach_m;  // a path that leaves began inside: a wall
}

}  // namespace

double cut_depth_m(const TriangleBvh& bone, const Vec3& point, const Vec3& normal, double edge_m) {
  constexpr int directions = 6;  // over half a turn: a ridge between two of them is cut 4 % less deep
  const Vec3 u = normal.unitOrthogonal();
  const Vec3 v = normal.cross(u);
  std::vector<PathCrossing> crossings;
  double deepest_m = 0;
  for (int i = 0; i < directions; ++i) {
    const double angle = std::numbers::pi * i / directions;
    const Vec3 half_edge = 0.5 * edge_m * (std::cos(angle) * u + std::sin(angle) * v);
    const double one_m = drop_m(bone, point, normal, half_edge, crossings);
    const double other_m = drop_m(bone, point, normal, -half_edge, crossings);
    deepest_m = std::max(deepest_m, 0.5 * (one_m + other_m));
  }
  return deepest_m;
}

std::vector<RidgeDepth> ridge_depths(const Scene& scene, std::size_t bone, const PoseEstimates& poses,
                                     const BoneNearness& nearness) {
  constexpr std::size_t most_looked_at = 20'000;
  std::vector<RidgeDepth> found(scene.muscles.size());
  std::vector<std::vector<double>> depths_m(scene.muscles.size());
  const TriangleBvh& tree = scene.bones[bone].signed_distance().tree();
  const std::vector<Body> bodies = scene.bodies();
  const std::size_t stride = nearness.near.size() / most_looked_at + 1;
  TriangleMesh posed = scene.muscle_mesh;
  std::vector<double> edge_m;
  std::optional<std::size_t> pose;
  for (std::size_t i = 0; i < nearness.near.size(); i += stride) {
    const NearNode& near = nearness.near[i];
    if (pose != near.pose) {
      pose = near.pose;
      for (std::size_t node = 0; node < posed.vertices.size(); ++node) {
        posed.vertices[node] = poses.position(*pose, static_cast<int>(node));
      }
      edge_m = node_edge_lengths_m(posed);
    }
    const double node_edge_m = edge_m[static_cast<std::size_t>(near.node)];
    if (near.signed_distance_m > node_edge_m) continue;
    const std::size_t muscle = body_of(bodies, near.node);
    const double depth_m = cut_depth_m(tree, near.point, near.normal, node_edge_m);
    depths_m[muscle].push_back(depth_m);
    if (depth_m > found[muscle].largest_m) {
      found[muscle].largest_m = depth_m;
      found[muscle].edge_m = node_edge_m;
      found[muscle].point = near.point;
    }
  }
  for (std::size_t muscle = 0; muscle < found.size(); ++muscle) {
    found[muscle].muscle = muscle;
    found[muscle].samples = static_cast<int>(depths_m[muscle].size());
    if (!depths_m[muscle].empty()) found[muscle].p99_m = percentile(depths_m[muscle], 0.99);
  }
  std::erase_if(found, [](const RidgeDepth& ridge) { return ridge.samples == 0; });
  return found;
}

}  // namespace musclebench

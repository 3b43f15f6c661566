#include "core/scene/check/bone_nearness.hpp"

#include <algorithm>
#include <limits>

#include "core/mesh/mesh_size.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Poses times nodes that are asked about, a bone: some tenths of a second.
constexpr std::size_t most_samples = 60'000;

std::vector<int> free_nodes(const Scene& scene) {
  std::vector<char> is_bound(scene.muscle_mesh.vertices.size(), 0);
  for (const BoundNode& bound : scene.bound_nodes()) is_bound[static_cast<std::size_t>(bound.node)] = 1;
  std::vector<int> nodes;
  for (std::size_t node = 0; node < is_bound.size(); ++node) {
    if (is_bound[node] == 0) nodes.push_back(static_cast<int>(node));
  }
  return nodes;
}

/// Queries of one bone, in its rest frame, as far as `reach_m` about its box.
class BoneQuery {
 public:
  BoneQuery(const Bone& bone, double reach_m)
      : m_surface(bone.signed_distance()), m_box(bounding_box(bone.surface.mesh.vertices)), m_reach_m(reach_m) {}

  /// Nothing for a point that is outside and farther than the reach.
  [[nodiscard]] std::optional<SignedPoint> locate(const Vec3& point) const {
    if (m_box.squaredExteriorDistance(point) > m_reach_m * m_reach_m) return std::nullopt;
    return m_surface.locate(point);
  }
  [[nodiscard]] NearNode near(int node, std::size_t pose, const Vec3& point, const Vec3& muscle_normal,
                              const SignedPoint& located) const {
    return {node,
            pose,
            located.closest.point,
            m_surface.outward(point, located),
            muscle_normal,
            located.signed_distance_m()};
  }

 private:
  const SignedSurface& m_surface;
  Eigen::AlignedBox3d m_box;
  double m_reach_m;
};

BoneNearness nearness_of(const Scene& scene, std::size_t bone, const PoseEstimates& poses,
                         const std::vector<double>& thickness_m, const std::vector<int>& free) {
  BoneNearness found{infinite, {}, infinite, {}};
  const double reach_m = thickness_m.empty() ? 0 : std::ranges::max(thickness_m);
  const BoneQuery query(scene.bones[bone], reach_m);
  const std::size_t stride = free.size() * poses.count() / most_samples + 1;
  TriangleMesh posed = scene.muscle_mesh;
  for (std::size_t pose = 0; pose < poses.count(); ++pose) {
    const RigidMotion& motion = poses.bone_poses(pose)[bone];
    for (std::size_t node = 0; node < posed.vertices.size(); ++node) {
      posed.vertices[node] = motion.apply_inverse(poses.position(pose, static_cast<int>(node)));
    }
    const std::vector<Vec3> normals = node_normals(posed);
    for (std::size_t i = 0; i < free.size(); i += pose == 0 ? 1 : stride) {
      const auto node = static_cast<std::size_t>(free[i]);
      const Vec3& point = posed.vertices[node];
      const auto located = query.locate(point);
      if (!located) continue;
      const double distance_m = located->signed_distance_m();
      if (pose == 0) {
        found.rest_distances_m.push_back(distance_m);
        if (distance_m > 0) found.rest_gap_m = std::min(found.rest_gap_m, distance_m);
      }
      if (i % stride != 0) continue;
      found.least_distance_m = std::min(found.least_distance_m, distance_m);
      if (distance_m <= thickness_m[node]) {
        found.near.push_back(query.near(free[i], pose, point, normals[node], *located));
      }
    }
  }
  return found;
}

}  // namespace

std::vector<BoneNearness> bone_nearness(const Scene& scene, const PoseEstimates& poses,
                                        const std::vector<double>& thickness_m) {
  const std::vector<int> free = free_nodes(scene);
  std::vector<BoneNearness> nearness;
  for (std::size_t bone = 0; bone < scene.bones.size(); ++bone) {
    nearness.push_back(nearness_of(scene, bone, poses, thickness_m, free));
  }
  return nearness;
}

std::vector<double> node_edge_lengths_m(const TriangleMesh& mesh) {
  std::vector<double> sum(mesh.vertices.size(), 0.0);
  std::vector<int> sides(mesh.vertices.size(), 0);
  for (const Triangle& triangle : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = static_cast<std::size_t>(triangle[k]);
      const auto b = static_cast<std::size_t>(triangle[(k + 1) % 3]);
      const double length_m = (mesh.vertices[b] - mesh.vertices[a]).norm();
      for (const std::size_t node : {a, b}) {
        sum[node] += length_m;
        ++sides[node];
      }
    }
  }
  for (std::size_t node = 0; node < sum.size(); ++node) sum[node] /= std::max(sides[node], 1);
  return sum;
}

std::vector<Vec3> node_normals(const TriangleMesh& mesh) {
  std::vector<Vec3> normals(mesh.vertices.size(), Vec3::Zero());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3& corner = mesh.vertices[static_cast<std::size_t>(a)];
    const Vec3 normal = (mesh.vertices[static_cast<std::size_t>(b)] - corner)
                            .cross(mesh.vertices[static_cast<std::size_t>(c)] - corner);
    for (const int node : {a, b, c}) normals[static_cast<std::size_t>(node)] += normal;
  }
  for (Vec3& normal : normals) normal.stableNormalize();
  return normals;
}

std::vector<double> node_thicknesses_m(const Scene& scene) {
  std::vector<double> thickness_m(scene.muscle_mesh.vertices.size(), 0.0);
  std::vector<PathCrossing> crossings;
  for (const Muscle& muscle : scene.muscles) {
    const TriangleMesh mesh = scene.mesh_of(muscle.body);
    const TriangleBvh tree(mesh);
    const double diagonal_m = bounding_box(mesh.vertices).diagonal().norm();
    const std::vector<Vec3> normals = node_normals(mesh);
    for (std::size_t node = 0; node < normals.size(); ++node) {
      const Vec3 inwards = -normals[node];
      // A little inside, so that the node's own triangles are not met.
      const Vec3 from = mesh.vertices[node] + 1e-4 * diagonal_m * inwards;
      tree.find_crossings(from, from + diagonal_m * inwards, crossings);
      if (crossings.empty() || crossings.front().entering) continue;
      thickness_m[static_cast<std::size_t>(muscle.body.first_node) + node] = crossings.front().share * diagonal_m;
    }
  }
  return thickness_m;
}

}  // namespace musclebench

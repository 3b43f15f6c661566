#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "core/mesh/shapes.hpp"

// Common to the tests of all backends: bones with a formula, a muscle that they cut into, and a detection.
namespace musclebench {

using Answer = std::set<std::pair<int, int>>;  // bone, node

inline Answer keys(const std::vector<Contact>& contacts) {
  Answer answer;
  for (const Contact& contact : contacts) {
    answer.insert({contact.bone, contact.node});
  }
  return answer;
}

/// A bone with a signed distance that a formula gives.
struct AnalyticBone {
  std::string name;
  TriangleMesh mesh;
  double (*signed_distance_m)(const Vec3&);
  double faceting_m;  ///< distance of the mesh from the shape that the formula means
};

inline constexpr double sphere_radius_m = 0.025;
inline constexpr double capsule_radius_m = 0.012;
inline constexpr double capsule_half_length_m = 0.02;
inline const Vec3 box_half_m(0.02, 0.03, 0.025);

inline std::vector<AnalyticBone> analytic_bones() {
  return {{"sphere", make_sphere(sphere_radius_m, 4), [](const Vec3& x) { return x.norm() - sphere_radius_m; }, 6e-5},
          {"box", make_box(box_half_m, 4),
           [](const Vec3& x) {
             const Vec3 q = x.cwiseAbs() - box_half_m;
             return q.cwiseMax(0).norm() + std::min(0.0, q.maxCoeff());
           },
           1e-15},
          {"capsule", make_capsule(capsule_radius_m, capsule_half_length_m, 64),
           [](const Vec3& x) {
             const double z = std::clamp(x.z(), -capsule_half_length_m, capsule_half_length_m);
             return (x - Vec3(0, 0, z)).norm() - capsule_radius_m;
           },
           3e-5}};
}

/// A muscle that the bone cuts into: a sphere whose surface runs through the origin.
inline TriangleMesh muscle() {
  TriangleMesh mesh = make_sphere(0.03, 3);
  for (Vec3& x : mesh.vertices) {
    x += Vec3(0.034, 0.006, -0.004);
  }
  return mesh;
}

inline std::vector<int> all_nodes(const TriangleMesh& mesh) {
  std::vector<int> nodes(mesh.vertices.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    nodes[i] = static_cast<int>(i);
  }
  return nodes;
}

inline std::vector<Vec3> moved(const std::vector<Vec3>& points, const RigidMotion& motion) {
  std::vector<Vec3> result;
  for (const Vec3& point : points) {
    result.push_back(motion.apply(point));
  }
  return result;
}

inline void expect_same_bits(const std::vector<Contact>& found, const std::vector<Contact>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].bone, expected[i].bone);
    ASSERT_EQ(found[i].node, expected[i].node);
    ASSERT_EQ(found[i].depth_m, expected[i].depth_m);
    ASSERT_EQ(found[i].normal, expected[i].normal);
  }
}

/// Each test has the name of a backend.
class Contract : public testing::TestWithParam<std::string> {
 public:
  std::unique_ptr<CollisionBackend> build(const std::string& name, const std::vector<Bone>& bones,
                                          const TriangleMesh& muscle_mesh, int threads = 1) {
    const BackendEntry& entry = find_backend(name);
    auto backend = entry.make(Parameters(entry.parameters, {}, "test"));
    backend->build(bones, muscle_mesh, threads);
    return backend;
  }

  static std::vector<Contact> detect(CollisionBackend& backend, const std::vector<RigidMotion>& poses,
                                     const std::vector<Vec3>& positions, const std::vector<int>& nodes) {
    std::vector<Contact> contacts;
    backend.update(poses, positions);
    backend.detect(positions, nodes, contacts);
    return contacts;
  }

  /// The control is there to find nothing: any depth may be missed.
  [[nodiscard]] bool collides() const { return GetParam() != "null"; }
};

inline std::vector<Bone> one_bone(const AnalyticBone& bone) { return {{bone.name, repair_mesh(bone.mesh, bone.name)}}; }

inline const RigidMotion tilted =
    RigidMotion::about_axis(Vec3(1, 2, -0.5).normalized(), Vec3(0.01, -0.02, 0.005), 0.9) *
    RigidMotion{Mat3::Identity(), Vec3(0.3, -0.1, 0.2)};

}  // namespace musclebench

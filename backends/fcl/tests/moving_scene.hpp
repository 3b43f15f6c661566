#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "core/contact/collision_backend.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {

inline Bone make_bone(const char* name, TriangleMesh mesh) {
  Bone bone;
  bone.name = name;
  bone.surface = {std::move(mesh), true, {}};
  return bone;
}

/// A sphere that bends, twists, grows and shrinks between a box and a ball that turn and wander, far from the origin.
struct MovingScene {
  std::vector<Bone> bones = {make_bone("box", make_box({0.03, 0.04, 0.05}, 5)),
                             make_bone("ball", make_sphere(0.04, 3))};
  TriangleMesh muscle = make_sphere(0.05, 3);

  static Vec3 origin() { return {0.4, -0.3, 1.1}; }

  std::vector<RigidMotion> poses(int step) const {
    const double s = step;
    const auto box = RigidMotion::about_axis(Vec3(1, 2, -1).normalized(), Vec3(0.01, 0, 0.02), 0.31 * s + 0.2);
    const auto ball = RigidMotion::about_axis(Vec3(-2, 1, 3).normalized(), Vec3(0, 0.02, 0), -0.47 * s);
    const RigidMotion box_pose{Mat3::Identity(), origin() + Vec3(0.06 - 0.004 * s, 0.003 * s, 0.01)};
    const RigidMotion ball_pose{Mat3::Identity(), origin() + Vec3(-0.07, 0.002, 0.0015 * s)};
    return {box_pose * box, ball_pose * ball};
  }

  std::vector<Vec3> positions(int step) const {
    const double s = step;
    std::vector<Vec3> moved;
    for (const Vec3& rest : muscle.vertices) {
      // Grows at both ends, then at one, then shrinks: what a broad phase must follow.
      const Vec3 scaled = rest.cwiseProduct(Vec3(1 + 0.15 * std::sin(s), 1 + 0.05 * s, 1 - 0.04 * s));
      const double twist = 12 * rest.z() * std::sin(0.9 * s);
      const Mat3 turn = Eigen::AngleAxisd(twist + 0.3 * s, Vec3::UnitZ()).toRotationMatrix();
      const double ripple = 0.002 * std::sin(150 * rest.x() + s) * std::cos(130 * rest.y() - s);
      moved.push_back(origin() + turn * scaled + ripple * rest.normalized() + Vec3(0, 0.001 * s * s, 0));
    }
    return moved;
  }
};

}  // namespace musclebench

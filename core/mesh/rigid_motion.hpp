#pragma once

#include <numbers>

#include <Eigen/Geometry>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Multiply radians by this to get degrees.
inline constexpr double degrees_per_radian = 180 / std::numbers::pi;

/// A rigid motion x -> rotation * x + translation_m. A bone's pose is the motion from its rest frame to the world
/// frame. `rotation` must be orthonormal: the inverse uses its transpose. Points are in metres.
struct RigidMotion {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation_m = Vec3::Zero();

  [[nodiscard]] Vec3 apply(const Vec3& point) const { return rotation * point + translation_m; }
  /// Rotates without translating.
  [[nodiscard]] Vec3 apply_to_direction(const Vec3& direction) const { return rotation * direction; }
  [[nodiscard]] Vec3 apply_inverse(const Vec3& point) const { return rotation.transpose() * (point - translation_m); }

  [[nodiscard]] RigidMotion inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation_m)}; }

  /// The motion that applies `other` first, then this one.
  [[nodiscard]] RigidMotion operator*(const RigidMotion& other) const {
    return {rotation * other.rotation, rotation * other.translation_m + translation_m};
  }

  /// A right-handed rotation by `angle_rad` about the line through `centre_m` along the unit vector `axis`, by
  /// Rodrigues' formula. The bits are the same on every CPU.
  [[nodiscard]] static RigidMotion about_axis(const Vec3& axis, const Vec3& centre_m, double angle_rad);
};

}  // namespace musclebench

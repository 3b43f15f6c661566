#pragma once

#include <numbers>

#include <Eigen/Geometry>

#include "core/base/portable_math.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

inline constexpr double degrees_per_radian = 180 / std::numbers::pi;

/// A rigid motion x -> rotation * x + translation_m. A bone's pose maps its rest frame to the world.
struct RigidMotion {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation_m = Vec3::Zero();

  [[nodiscard]] Vec3 apply(const Vec3& point) const { return rotation * point + translation_m; }
  [[nodiscard]] Vec3 apply_to_direction(const Vec3& direction) const { return rotation * direction; }
  [[nodiscard]] Vec3 apply_inverse(const Vec3& point) const { return rotation.transpose() * (point - translation_m); }

  [[nodiscard]] RigidMotion inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation_m)}; }

  /// First `other`, then this.
  [[nodiscard]] RigidMotion operator*(const RigidMotion& other) const {
    return {rotation * other.rotation, rotation * other.translation_m + translation_m};
  }

  /// Rotation by `angle_rad` about the line through `centre_m` along the unit vector `axis`, right-handed.
  [[nodiscard]] static RigidMotion about_axis(const Vec3& axis, const Vec3& centre_m, double angle_rad) {
    const double sine = portable::sin(angle_rad);
    const double cosine = portable::cos(angle_rad);
    Mat3 across;  // axis x
    across << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
    const Mat3 rotation = cosine * Mat3::Identity() + sine * across + (1 - cosine) * axis * axis.transpose();
    return {rotation, centre_m - rotation * centre_m};
  }
};

}  // namespace musclebench

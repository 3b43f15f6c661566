#pragma once

#include <cstddef>

#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// What FCL does not tell about one bone: it takes a surface for hollow, and which side a point is on is
/// SignedSurface's answer. All points are points of the bone's rest frame. The members are those of a
/// QuerySurface, where they are described. Safe from several threads.
class SignedFclSurface {
 public:
  explicit SignedFclSurface(const RepairedMesh& surface);

  [[nodiscard]] bool is_outside(const Vec3& point, double& clearance_m) const;
  [[nodiscard]] ClosestOnTriangle closest_on(const Vec3& point, int triangle) const {
    return m_sides.tree().closest_on(point, triangle);
  }
  [[nodiscard]] double distance_m(const Vec3& point, int triangle) const;
  [[nodiscard]] bool contains(const Vec3& point, const ClosestPoint& closest) const;
  [[nodiscard]] Vec3 outward(const Vec3& point, const ClosestPoint& closest) const;

  /// A point closer to the surface than this is not contained: which side it is on is rounding.
  [[nodiscard]] double touching_m() const { return m_touching_m; }

 protected:
  [[nodiscard]] const SignedSurface& sides() const { return m_sides; }
  /// What distances of triangles that were measured here (`closest_on`) and in other ways differ by at most, besides a
  /// share of them: `rounding_share`.
  [[nodiscard]] double rounding_m() const { return m_rounding_m; }
  static constexpr double rounding_share = 1e-9;
  /// How far FCL has to look for all triangles that may be measured as no farther than this.
  [[nodiscard]] double reach_m(double distance_m) const { return (1 + rounding_share) * distance_m + m_rounding_m; }

 private:
  SignedSurface m_sides;
  Eigen::AlignedBox3d m_box;
  double m_touching_m;
  double m_rounding_m;
};

}  // namespace musclebench

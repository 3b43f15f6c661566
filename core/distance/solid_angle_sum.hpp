#pragma once

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The signed solid angles of many triangles seen from one point, summed with one arc tangent at the end: the tangent
/// of half an angle is a quotient (van Oosterom and Strackee 1983), so that halves are added by multiplying complex
/// numbers, and the times that the product passes the negative real axis are counted.
class SolidAngleSum {
 public:
  explicit SolidAngleSum(const Vec3& point) : m_point(point) {}

  /// Nothing for a degenerate triangle and in the triangle's plane, as `solid_angle`.
  void add(const Vec3& a, const Vec3& b, const Vec3& c);

  [[nodiscard]] double steradians() const;

  /// Of a closed surface wound outwards 1 inside and 0 outside; of an open one anything between.
  [[nodiscard]] double winding_number() const;

 private:
  Vec3 m_point;
  double m_real = 1;
  double m_imaginary = 0;
  int m_turns = 0;  ///< of the product about 0, each two whole spheres
};

}  // namespace musclebench

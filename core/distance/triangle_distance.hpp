#pragma once

#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The feature of a triangle that contains the closest point. `edge_i` runs from corner i to corner (i + 1) % 3.
enum class Feature : unsigned char { face, edge_0, edge_1, edge_2, corner_0, corner_1, corner_2 };

/// The closest point of one triangle, in the frame of its corners.
struct ClosestOnTriangle {
  Vec3 point = Vec3::Zero();
  double squared_distance_m2 = 0;
  Feature feature = Feature::face;
};

/// A triangle whose corners have smaller sines is indistinguishable from a segment or a point in double precision.
inline constexpr double flat_sine = 1e-13;

/// Whether a triangle has an area, given two of its sides and the square of their cross product.
inline bool has_area(double squared_normal, const Vec3& ab, const Vec3& ac) {
  const double squared_ab = ab.squaredNorm();
  const double squared_ac = ac.squaredNorm();
  const double product = squared_ab * squared_ac;
  // Square roots are needed only close to the threshold.
  if (squared_normal > 10 * flat_sine * flat_sine * product && product > 1e-200) {
    return true;
  }
  const double flat = flat_sine * std::sqrt(squared_ab) * std::sqrt(squared_ac);
  return squared_normal > flat * flat;
}

/// Closest point of the three edges of the triangle a b c to `point`.
ClosestOnTriangle closest_on_edges(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c);

/// Closest point of the triangle a b c to `point`, in metres as these: the foot of the perpendicular if its barycentric
/// coordinates are in the triangle, else the closest point of the edges. A degenerate triangle is treated as the
/// segment or point that it is. All exact queries rest on this function: of two equal distances they take the smaller
/// index.
inline ClosestOnTriangle closest_on_triangle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 ap = point - a;
  const Vec3 normal = ab.cross(ac);
  const double squared_normal = normal.squaredNorm();
  ClosestOnTriangle best;
  if (has_area(squared_normal, ab, ac)) {
    // From the corners instead of along the normal, so that the foot stays in the plane of a sliver, too.
    const double v = normal.dot(ap.cross(ac)) / squared_normal;
    const double w = normal.dot(ab.cross(ap)) / squared_normal;
    if (v >= 0 && w >= 0 && v + w <= 1) {
      best.point = a + v * ab + w * ac;
      best.squared_distance_m2 = (point - best.point).squaredNorm();
      return best;
    }
  }
  return closest_on_edges(point, a, b, c);
}

/// The tangent of an angle as its quotient, in m^3.
struct HalfAngleTangent {
  double opposite;
  double adjacent;
};

/// Of half the signed solid angle of the triangle a b c; see `solid_angle`.
HalfAngleTangent half_solid_angle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c);

/// Signed solid angle of the triangle a b c seen from `point`, in steradians (van Oosterom and Strackee 1983). Positive
/// where `point` sees the back of the triangle, so that the angles of a closed surface wound outwards sum to 4 pi at a
/// point inside. 0 for a degenerate triangle and in the triangle's plane.
double solid_angle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c);

/// Barycentric coordinates of a point in the plane of a triangle with these corners, moved into the triangle: each from
/// 0 to 1, the sum is 1. `flat` for one without an area.
Vec3 barycentric(const Vec3& point, const std::array<Vec3, 3>& corners, const Vec3& flat);

}  // namespace musclebench

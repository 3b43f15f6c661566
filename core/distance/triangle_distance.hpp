#pragma once

#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The part of a triangle that contains a closest point. `edge_i` runs from corner i to corner (i + 1) % 3.
enum class Feature : unsigned char { face, edge_0, edge_1, edge_2, corner_0, corner_1, corner_2 };

/// The closest point of one triangle to a query point. It is in metres, in the frame of the corners.
struct ClosestOnTriangle {
  Vec3 point = Vec3::Zero();
  double squared_distance_m2 = 0;
  Feature feature = Feature::face;
};

/// If the sine of every corner angle is smaller than this, the triangle counts as a segment or a point.
inline constexpr double flat_sine = 1e-13;

/// Whether a triangle has an area. `ab` and `ac` are two of its sides, `squared_normal` is |ab x ac|^2.
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

/// The point on the three edges of the triangle a b c that is closest to `point`. All points are in metres, in one
/// frame.
ClosestOnTriangle closest_on_edges(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c);

/// The point of the triangle a b c that is closest to `point`. All points are in metres, in one frame. It is the foot
/// of the perpendicular if that lies in the triangle, else the closest point of the edges. A triangle without area
/// counts as a segment or a point. All exact queries use this function. If distances are equal, they take the triangle
/// with the smaller index. Safe from several threads, as are all functions here.
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

/// The tangent of an angle as the quotient opposite / adjacent. Both are in m^3.
struct HalfAngleTangent {
  double opposite;
  double adjacent;
};

/// The tangent of half the signed solid angle of the triangle a b c. See `solid_angle` for the sign.
HalfAngleTangent half_solid_angle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c);

/// The signed solid angle of the triangle a b c seen from `point`, in steradians (van Oosterom and Strackee 1983). It
/// is positive if `point` sees the back of the triangle. The angles of a closed surface that is wound outwards thus sum
/// to 4 pi at a point inside. It is 0 for a triangle without area and for a point in the triangle's plane.
double solid_angle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c);

/// The barycentric coordinates of a point in the plane of a triangle. They are clamped to the triangle: each is from 0
/// to 1, and the sum is 1. Returns `flat` if the triangle has no area.
Vec3 barycentric(const Vec3& point, const std::array<Vec3, 3>& corners, const Vec3& flat);

}  // namespace musclebench

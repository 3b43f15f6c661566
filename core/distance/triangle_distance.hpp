#pragma once

#include <cmath>

#include <Eigen/Geometry>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The part of a triangle that holds the closest point. `edge_i` runs from corner i to corner (i + 1) % 3.
enum class Feature : unsigned char { face, edge_0, edge_1, edge_2, corner_0, corner_1, corner_2 };

struct ClosestOnTriangle {
  Vec3 point = Vec3::Zero();
  double squared_distance_m2 = 0;
  Feature feature = Feature::face;
};

/// Sines of corner angles below this are rounding: the triangle is then a segment or a point.
inline constexpr double flat_sine = 1e-13;

/// Whether a triangle is more than a segment, given two of its sides and the square of their cross product.
inline bool has_area(double squared_normal, const Vec3& ab, const Vec3& ac) {
  const double squared_ab = ab.squaredNorm();
  const double squared_ac = ac.squaredNorm();
  const double product = squared_ab * squared_ac;
  // Far from the border, as nearly all are, roots are not needed.
  if (squared_normal > 10 * flat_sine * flat_sine * product && product > 1e-200) {
    return true;
  }
  const double flat = flat_sine * std::sqrt(squared_ab) * std::sqrt(squared_ac);
  return squared_normal > flat * flat;
}

/// The closest point of the three edges.
ClosestOnTriangle closest_on_edges(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c);

/// Closest point of the triangle a b c to `point`: the foot of the perpendicular where that lies in the triangle (its
/// barycentric coordinates tell), else the closest point of the three edges. A degenerate triangle is answered as the
/// segment or point that it is.
inline ClosestOnTriangle closest_on_triangle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 ap = point - a;
  const Vec3 normal = ab.cross(ac);
  const double squared_normal = normal.squaredNorm();
  ClosestOnTriangle best;
  if (has_area(squared_normal, ab, ac)) {
    // The foot is built from the corners rather than along the normal, so that it stays in the plane of a sliver, too.
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

/// Signed solid angle of the triangle a b c seen from `point`, in steradians, positive where the triangle's back is
/// seen, so that a closed outward surface sums to 4 pi at an inner point (van Oosterom and Strackee 1983). 0 for a
/// degenerate triangle and in a triangle's own plane.
double solid_angle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace musclebench

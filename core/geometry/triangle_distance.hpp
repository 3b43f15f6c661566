#pragma once

#include "core/geometry/triangle_mesh.hpp"

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

/// Closest point of the triangle a b c to `point`: the foot of the perpendicular where that lies in the triangle (its
/// barycentric coordinates tell), else the closest point of the three edges. A degenerate triangle is answered as the
/// segment or point that it is.
ClosestOnTriangle closest_on_triangle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c);

/// Signed solid angle of the triangle a b c seen from `point`, in steradians, positive where the triangle's back is
/// seen, so that a closed outward surface sums to 4 pi at an inner point (van Oosterom and Strackee 1983). 0 for a
/// degenerate triangle and in a triangle's own plane.
double solid_angle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace musclebench

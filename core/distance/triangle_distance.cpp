#include "core/distance/triangle_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "core/base/arc_tangent.hpp"

namespace musclebench {

namespace {

Feature edge_feature(int edge) { return static_cast<Feature>(static_cast<int>(Feature::edge_0) + edge); }

Feature corner_feature(int corner) { return static_cast<Feature>(static_cast<int>(Feature::corner_0) + corner % 3); }

void take_edge_if_closer(const Vec3& point, const Vec3& from, const Vec3& to, int edge, ClosestOnTriangle& best) {
  const Vec3 direction = to - from;
  const double along = direction.dot(point - from);
  const double squared_length = direction.squaredNorm();
  ClosestOnTriangle candidate;
  if (along <= 0) {
    candidate.point = from;
    candidate.feature = corner_feature(edge);
  } else if (along >= squared_length) {
    candidate.point = to;
    candidate.feature = corner_feature(edge + 1);
  } else {
    candidate.point = from + direction * (along / squared_length);
    candidate.feature = edge_feature(edge);
  }
  candidate.squared_distance_m2 = (point - candidate.point).squaredNorm();
  if (candidate.squared_distance_m2 < best.squared_distance_m2) {
    best = candidate;
  }
}

}  // namespace

ClosestOnTriangle closest_on_edges(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c) {
  ClosestOnTriangle best;
  best.squared_distance_m2 = std::numeric_limits<double>::infinity();
  take_edge_if_closer(point, a, b, 0, best);
  take_edge_if_closer(point, b, c, 1, best);
  take_edge_if_closer(point, c, a, 2, best);
  return best;
}

HalfAngleTangent half_solid_angle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 pa = a - point;
  const Vec3 pb = b - point;
  const Vec3 pc = c - point;
  const double la = pa.norm();
  const double lb = pb.norm();
  const double lc = pc.norm();
  return {pa.dot(pb.cross(pc)), la * lb * lc + pa.dot(pb) * lc + pb.dot(pc) * la + pc.dot(pa) * lb};
}

double solid_angle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto [opposite, adjacent] = half_solid_angle(point, a, b, c);
  return opposite == 0 ? 0.0 : 2 * arc_tangent2(opposite, adjacent);
}

Vec3 barycentric(const Vec3& point, const std::array<Vec3, 3>& corners, const Vec3& flat) {
  const auto& [a, b, c] = corners;
  const Vec3 normal = (b - a).cross(c - a);
  const double squared = normal.squaredNorm();
  if (!(squared > 0)) return flat;
  const double v = std::clamp(normal.dot((point - a).cross(c - a)) / squared, 0.0, 1.0);
  const double w = std::clamp(normal.dot((b - a).cross(point - a)) / squared, 0.0, 1.0 - v);
  return {1 - v - w, v, w};
}

}  // namespace musclebench

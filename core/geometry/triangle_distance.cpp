#include "core/geometry/triangle_distance.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>

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

ClosestOnTriangle closest_on_triangle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 ap = point - a;
  const Vec3 normal = ab.cross(ac);
  const double squared_normal = normal.squaredNorm();
  const double flat = flat_sine * ab.norm() * ac.norm();
  ClosestOnTriangle best;
  if (squared_normal > flat * flat) {
    // The foot is built from the corners rather than along the normal, so that it stays in the plane of a needle, too.
    const double v = normal.dot(ap.cross(ac)) / squared_normal;
    const double w = normal.dot(ab.cross(ap)) / squared_normal;
    if (v >= 0 && w >= 0 && v + w <= 1) {
      best.point = a + v * ab + w * ac;
      best.squared_distance_m2 = (point - best.point).squaredNorm();
      return best;
    }
  }
  best.squared_distance_m2 = std::numeric_limits<double>::infinity();
  take_edge_if_closer(point, a, b, 0, best);
  take_edge_if_closer(point, b, c, 1, best);
  take_edge_if_closer(point, c, a, 2, best);
  return best;
}

double solid_angle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 pa = a - point;
  const Vec3 pb = b - point;
  const Vec3 pc = c - point;
  const double la = pa.norm();
  const double lb = pb.norm();
  const double lc = pc.norm();
  const double volume = pa.dot(pb.cross(pc));
  const double projected = la * lb * lc + pa.dot(pb) * lc + pb.dot(pc) * la + pc.dot(pa) * lb;
  return volume == 0 ? 0.0 : 2 * std::atan2(volume, projected);
}

}  // namespace musclebench

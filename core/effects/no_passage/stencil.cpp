#include "core/effects/no_passage/stencil.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/distance/triangle_distance.hpp"

namespace musclebench {

namespace {

/// Of the distance that is left a step takes this much.
constexpr double step_share = 0.9;
/// Each step is safe on its own; a motion that takes more is cut short.
constexpr int most_steps = 1000;

StencilGap gap_at(const StencilCorners& corners, const std::array<double, 4>& weights) {
  StencilGap gap{weights, Vec3::Zero(), 0};
  for (std::size_t k = 0; k < 4; ++k) gap.apart += weights[k] * corners[k];
  gap.distance_m = gap.apart.norm();
  return gap;
}

/// Position along an edge of the point closest to `point`, 0 to 1.
double along_edge(const Vec3& point, const Vec3& from, const Vec3& to) {
  const Vec3 edge = to - from;
  const double squared = edge.squaredNorm();
  return squared > 0 ? std::clamp(edge.dot(point - from) / squared, 0.0, 1.0) : 0.0;
}

StencilGap gap_of_edges(const StencilCorners& corners) {
  const auto& [a, b, c, d] = corners;
  const auto gap_with = [&](double s, double t) { return gap_at(corners, {1 - s, s, t - 1, -t}); };
  // The inner solution counts only if it is the best: near parallel edges it is rounding.
  StencilGap best = gap_with(0, along_edge(a, c, d));
  const auto take = [&](const StencilGap& other) {
    if (other.distance_m < best.distance_m) best = other;
  };
  take(gap_with(1, along_edge(b, c, d)));
  take(gap_with(along_edge(c, a, b), 0));
  take(gap_with(along_edge(d, a, b), 1));
  const Vec3 u = b - a;
  const Vec3 v = d - c;
  const Vec3 across = u.cross(v);
  const double squared = across.squaredNorm();
  if (squared > 0) {
    const Vec3 between = c - a;
    const double s = between.cross(v).dot(across) / squared;
    const double t = between.cross(u).dot(across) / squared;
    if (s > 0 && s < 1 && t > 0 && t < 1) take(gap_with(s, t));
  }
  return best;
}

double squared_distance_of_edges(const StencilCorners& corners) {
  const auto& [a, b, c, d] = corners;
  const Vec3 u = b - a;
  const Vec3 v = d - c;
  const Vec3 w = a - c;
  const double uu = u.squaredNorm();
  const double vv = v.squaredNorm();
  const double uv = u.dot(v);
  const double uw = u.dot(w);
  const double vw = v.dot(w);
  const auto share = [](double part, double whole) { return whole > 0 ? std::clamp(part / whole, 0.0, 1.0) : 0.0; };
  const auto squared = [&](double s, double t) { return (w + s * u - t * v).squaredNorm(); };
  double least = std::min(std::min(squared(0, share(vw, vv)), squared(1, share(vw + uv, vv))),
                          std::min(squared(share(-uw, uu), 0), squared(share(uv - uw, uu), 1)));
  const double determinant = uu * vv - uv * uv;
  if (determinant > 0) {
    const double s = (uv * vw - vv * uw) / determinant;
    const double t = (uu * vw - uv * uw) / determinant;
    if (s > 0 && s < 1 && t > 0 && t < 1) least = std::min(least, squared(s, t));
  }
  return least;
}

StencilGap gap_of_node(const StencilCorners& corners) {
  const auto& [p, a, b, c] = corners;
  const ClosestOnTriangle closest = closest_on_triangle(p, a, b, c);
  Vec3 weights = Vec3::Zero();
  switch (closest.feature) {
    case Feature::face:
      weights = barycentric(closest.point, {a, b, c}, Vec3::UnitX());
      break;
    case Feature::corner_0:
      weights = Vec3::UnitX();
      break;
    case Feature::corner_1:
      weights = Vec3::UnitY();
      break;
    case Feature::corner_2:
      weights = Vec3::UnitZ();
      break;
    default: {
      const auto edge = static_cast<std::size_t>(closest.feature) - static_cast<std::size_t>(Feature::edge_0);
      const std::size_t next = (edge + 1) % 3;
      const double along = along_edge(p, corners[1 + edge], corners[1 + next]);
      weights[static_cast<Eigen::Index>(edge)] = 1 - along;
      weights[static_cast<Eigen::Index>(next)] = along;
    }
  }
  StencilGap gap{{1, -weights[0], -weights[1], -weights[2]}, p - closest.point, 0};
  gap.distance_m = gap.apart.norm();
  return gap;
}

}  // namespace

StencilGap gap_of(StencilKind kind, const StencilCorners& corners) {
  return kind == StencilKind::node_face ? gap_of_node(corners) : gap_of_edges(corners);
}

double distance_of(StencilKind kind, const StencilCorners& corners) {
  if (kind == StencilKind::node_face) {
    return (corners[0] - closest_on_triangle(corners[0], corners[1], corners[2], corners[3]).point).norm();
  }
  return std::sqrt(squared_distance_of_edges(corners));
}

bool stay_apart(StencilKind kind, const StencilGap& before, const StencilCorners& end, double least_m) {
  if (!(before.distance_m > least_m)) return false;
  const std::size_t second = kind == StencilKind::node_face ? 1 : 2;
  double first_m = std::numeric_limits<double>::infinity();
  double second_m = -first_m;
  for (std::size_t k = 0; k < 4; ++k) {
    const double along_m = before.apart.dot(end[k]) / before.distance_m;
    if (k < second) {
      first_m = std::min(first_m, along_m);
    } else {
      second_m = std::max(second_m, along_m);
    }
  }
  return first_m - second_m > least_m;
}

double safe_share(StencilKind kind, const StencilCorners& start, const StencilCorners& end, double least_m) {
  StencilCorners moves;
  Vec3 mean = Vec3::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    moves[k] = end[k] - start[k];
    mean += 0.25 * moves[k];
  }
  const std::size_t second = kind == StencilKind::node_face ? 1 : 2;
  double first_m = 0;
  double second_m = 0;
  StencilCorners relative_end;
  for (std::size_t k = 0; k < 4; ++k) {
    moves[k] -= mean;
    relative_end[k] = start[k] + moves[k];
    double& longest_m = k < second ? first_m : second_m;
    longest_m = std::max(longest_m, moves[k].norm());
  }
  const double approach_m = first_m + second_m;
  StencilGap gap = gap_of(kind, start);
  double left_m = gap.distance_m - least_m;
  if (!(approach_m > 0) || approach_m < left_m) return 1;
  constexpr double hardly = 1 - 1e-9;
  if (!(left_m > 0)) return stay_apart(kind, gap, relative_end, hardly * gap.distance_m) ? 1 : 0;
  double share = 0;
  for (int step = 0; step < most_steps; ++step) {
    if (stay_apart(kind, gap, relative_end, least_m)) return 1;
    share += step_share * left_m / approach_m;
    if (share >= 1) return 1;
    StencilCorners at;
    for (std::size_t k = 0; k < 4; ++k) at[k] = start[k] + share * moves[k];
    gap = gap_of(kind, at);
    left_m = gap.distance_m - least_m;
    if (left_m < enough_share * least_m) return share;
  }
  return share;
}

}  // namespace musclebench

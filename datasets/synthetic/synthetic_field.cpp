#include "datasets/synthetic/synthetic_field.hpp"

#include <algorithm>
#include <cmath>

namespace musclebench {

namespace {

constexpr int pieces_per_span = 3;

struct Ball {
  Vec3 centre_m;
  double radius_m;
};

Ball ball(const Station& station) {
  return {1e-3 * Vec3(station.x_mm, station.y_mm, station.z_mm), 1e-3 * station.radius_mm};
}

/// Catmull-Rom between `b` and `c`; the radius runs straight, for a spline could overshoot below zero.
Ball between(const Ball& a, const Ball& b, const Ball& c, const Ball& d, double t) {
  const Vec3 centre = 0.5 * (2.0 * b.centre_m + t * (c.centre_m - a.centre_m) +
                             t * t * (2.0 * a.centre_m - 5.0 * b.centre_m + 4.0 * c.centre_m - d.centre_m) +
                             t * t * t * (3.0 * (b.centre_m - c.centre_m) + d.centre_m - a.centre_m));
  return {centre, (1.0 - t) * b.radius_m + t * c.radius_m};
}

std::vector<Ball> sample_curve(std::span<const Station> stations) {
  const auto at = [&](std::ptrdiff_t i) {
    return ball(stations[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, std::ssize(stations) - 1))]);
  };
  const int pieces = stations.size() == 2 ? 1 : pieces_per_span;
  std::vector<Ball> balls;
  for (std::ptrdiff_t span = 0; span + 1 < std::ssize(stations); ++span) {
    for (int piece = 0; piece < pieces; ++piece) {
      balls.push_back(between(at(span - 1), at(span), at(span + 1), at(span + 2), static_cast<double>(piece) / pieces));
    }
  }
  balls.push_back(at(std::ssize(stations) - 1));
  return balls;
}

bool beyond(const Vec3& point, const Vec3& centre_m, double reach_m, double limit_m) {
  const double distance_limit = limit_m + reach_m;
  return distance_limit <= 0 || (point - centre_m).squaredNorm() >= distance_limit * distance_limit;
}

}  // namespace

double smooth_min(double a, double b, double blend) {
  const double overlap = std::max(blend - std::abs(a - b), 0.0) / blend;
  return std::min(a, b) - 0.25 * overlap * overlap * blend;
}

double smooth_max(double a, double b, double blend) { return -smooth_min(-a, -b, blend); }

Strand::Strand(std::span<const Station> stations) {
  const std::vector<Ball> balls = sample_curve(stations);
  Vec3 lower = Vec3::Constant(1e3);
  Vec3 upper = Vec3::Constant(-1e3);
  for (const Ball& b : balls) {
    lower = lower.cwiseMin(b.centre_m);
    upper = upper.cwiseMax(b.centre_m);
  }
  m_centre_m = 0.5 * (lower + upper);
  for (const Ball& b : balls) {
    m_reach_m = std::max(m_reach_m, (b.centre_m - m_centre_m).norm() + b.radius_m);
  }
  for (std::size_t i = 0; i + 1 < balls.size(); ++i) {
    const Vec3 span = balls[i + 1].centre_m - balls[i].centre_m;
    const double length = span.norm();
    const double drop = std::clamp((balls[i].radius_m - balls[i + 1].radius_m) / length, -0.99, 0.99);
    m_cones.push_back({balls[i].centre_m, span / length, length, balls[i].radius_m, drop,
                       drop / std::sqrt(1.0 - drop * drop), balls[i].centre_m + 0.5 * span,
                       0.5 * length + std::max(balls[i].radius_m, balls[i + 1].radius_m)});
  }
}

double Strand::distance(const Vec3& point, double limit_m) const {
  double result = limit_m;
  if (beyond(point, m_centre_m, m_reach_m, result)) {
    return result;
  }
  for (const RoundCone& cone : m_cones) {
    if (beyond(point, cone.centre_m, cone.reach_m, result)) {
      continue;
    }
    // Among the balls along the segment, the nearest one lies where the line to the point meets the cone's side at a
    // right angle.
    const Vec3 offset = point - cone.start_m;
    const double along = offset.dot(cone.direction);
    const double across = std::sqrt(std::max(offset.squaredNorm() - along * along, 0.0));
    const double t = std::clamp(along - across * cone.slope_ratio, 0.0, cone.length_m);
    const double radius = cone.start_radius_m - t * cone.radius_drop;
    result = std::min(result, std::sqrt((along - t) * (along - t) + across * across) - radius);
  }
  return result;
}

double StrandBundle::distance(const Vec3& point, double start_m) const {
  double result = start_m;
  for (const Strand& strand : m_strands) {
    result = smooth_min(result, strand.distance(point, result + m_blend_m), m_blend_m);
  }
  return result;
}

}  // namespace musclebench

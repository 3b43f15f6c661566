#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

/// The answers that the Referee must give, found by brute force: every triangle, long double, Voronoi regions.
namespace musclebench::naive {

using Real = long double;
using Point = Eigen::Matrix<Real, 3, 1>;

inline Real distance_to_segment(const Point& p, const Point& a, const Point& b) {
  const Real length2 = (b - a).squaredNorm();
  const Real t = length2 > 0 ? std::clamp<Real>((p - a).dot(b - a) / length2, 0, 1) : 0;
  return (a + t * (b - a) - p).norm();
}

inline Real distance_to_triangle(const Point& p, const Point& a, const Point& b, const Point& c) {
  const Point normal = (b - a).cross(c - a);
  const Real to_edges =
      std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
  const Real weight_a = (c - b).cross(p - b).dot(normal);
  const Real weight_b = (a - c).cross(p - c).dot(normal);
  const Real weight_c = (b - a).cross(p - a).dot(normal);
  if (!(weight_a > 0 && weight_b > 0 && weight_c > 0)) return to_edges;
  // The distance to the foot, not to the plane: for a sliver the normal is poor, and an error of the foot counts
  // squared.
  const Point foot = (weight_a * a + weight_b * b + weight_c * c) / (weight_a + weight_b + weight_c);
  return std::min(to_edges, (p - foot).norm());
}

/// Distance from `p` to the surface. Triangles that a sphere around them proves to be farther are passed over.
inline double distance(const TriangleMesh& mesh, const Vec3& p) {
  Real best = std::numeric_limits<Real>::infinity();
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[static_cast<std::size_t>(t[0])];
    const Vec3& b = mesh.vertices[static_cast<std::size_t>(t[1])];
    const Vec3& c = mesh.vertices[static_cast<std::size_t>(t[2])];
    const double reach = 1.001 * std::sqrt(std::max((b - a).squaredNorm(), (c - a).squaredNorm()));
    const double sure = 1.001 * static_cast<double>(best) + reach;
    if ((p - a).squaredNorm() > sure * sure) continue;
    best = std::min(best, distance_to_triangle(p.cast<Real>(), a.cast<Real>(), b.cast<Real>(), c.cast<Real>()));
  }
  return static_cast<double>(best);
}

/// Sum of the solid angles of all triangles, over 4 pi.
inline double winding_number(const TriangleMesh& mesh, const Vec3& p) {
  double sum = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[static_cast<std::size_t>(t[0])] - p;
    const Vec3 b = mesh.vertices[static_cast<std::size_t>(t[1])] - p;
    const Vec3 c = mesh.vertices[static_cast<std::size_t>(t[2])] - p;
    const double la = a.norm();
    const double lb = b.norm();
    const double lc = c.norm();
    sum += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (2 * std::numbers::pi);
}

inline double diagonal(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& vertex : mesh.vertices) box.extend(vertex);
  return box.sizes().norm();
}

/// Points spread evenly over the surface's box, enlarged by half its size.
inline std::vector<Vec3> cloud(const TriangleMesh& mesh, int count, std::mt19937_64& random) {
  Eigen::AlignedBox3d box;
  for (const Vec3& vertex : mesh.vertices) box.extend(vertex);
  std::uniform_real_distribution<double> within(-0.75, 0.75);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(box.center() + box.sizes().cwiseProduct(Vec3(within(random), within(random), within(random))));
  }
  return points;
}

/// Points of the surface, moved by about `jitter_m` along each axis.
inline std::vector<Vec3> near_surface(const TriangleMesh& mesh, int count, double jitter_m, std::mt19937_64& random) {
  std::uniform_int_distribution<std::size_t> which(0, mesh.triangles.size() - 1);
  std::uniform_real_distribution<double> share(0, 1);
  std::normal_distribution<double> jitter(0, jitter_m);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const Triangle& t = mesh.triangles[which(random)];
    const double u = share(random);
    const double v = share(random) * (1 - u);
    const auto corner = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    points.emplace_back((1 - u - v) * corner(0) + u * corner(1) + v * corner(2) +
                        Vec3(jitter(random), jitter(random), jitter(random)));
  }
  return points;
}

inline std::vector<Vec3> edge_midpoints(const TriangleMesh& mesh) {
  std::vector<Vec3> points;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      points.emplace_back(0.5 * (mesh.vertices[static_cast<std::size_t>(t[k])] +
                                 mesh.vertices[static_cast<std::size_t>(t[(k + 1) % 3])]));
    }
  }
  return points;
}

}  // namespace musclebench::naive

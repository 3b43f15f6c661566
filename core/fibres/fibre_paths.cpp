#include "core/fibres/fibre_paths.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "core/mesh/mesh_size.hpp"
#include "core/mesh/morton_order.hpp"

namespace musclebench {

namespace {

/// Of a cell: how far a streamline goes at a time.
constexpr double step_cells = 0.5;
/// A streamline that ends farther than this from its area, in cells, has lost its way.
constexpr double farthest_end_cells = 4;
/// So far below the origin a streamline begins: nearer the flow is that of the grid.
constexpr double first_cells = 1;
/// So near to the insertion the rest of a streamline is straight.
constexpr double last_cells = 1;

class Tracer {
 public:
  Tracer(const VolumePotential& potential, const TriangleMesh& muscle, const SignedSurface& surface)
      : m_potential(potential),
        m_surface(surface),
        m_step_m(step_cells * potential.cell_size_m()),
        m_most_steps(static_cast<int>(20 * bounding_box(muscle.vertices).diagonal().norm() / m_step_m)) {}

  /// From `seed`, which is inside, to the insertion, as far as the flow leads.
  [[nodiscard]] std::vector<Vec3> trace(const Vec3& seed, const std::vector<char>& is_insertion) const {
    std::vector<Vec3> points{seed};
    double potential = m_potential.at(seed).potential;
    for (int step = 0; step < m_most_steps; ++step) {
      const Vec3 next = kept_inside(advanced(points.back()));
      const double there = m_potential.at(next).potential;
      // Beside a wall a streamline may slide along it, but it never turns back.
      if (!(there > potential)) break;
      points.push_back(next);
      potential = there;
      const ClosestPoint closest = m_surface.locate(next).closest;
      const bool is_near = closest.distance_m < last_cells * m_potential.cell_size_m();
      if (is_near && is_insertion[static_cast<std::size_t>(closest.triangle)] != 0) break;
    }
    return points;
  }

  /// The grid knows the surface to a fraction of a cell only.
  [[nodiscard]] Vec3 kept_inside(const Vec3& point) const {
    const SignedPoint located = m_surface.locate(point);
    constexpr double depth_cells = 0.05;
    const double depth_m = depth_cells * m_potential.cell_size_m();
    if (located.signed_distance_m() <= -depth_m) return point;
    return point - (located.signed_distance_m() + depth_m) * m_surface.outward(point, located);
  }

 private:
  [[nodiscard]] Vec3 direction(const Vec3& point) const {
    const Vec3 flow = m_potential.at(point).flow;
    const double speed = flow.norm();
    return speed > 0 ? Vec3(flow / speed) : Vec3::Zero();
  }

  /// By the classical Runge-Kutta method.
  [[nodiscard]] Vec3 advanced(const Vec3& point) const {
    const Vec3 a = direction(point);
    const Vec3 b = direction(point + 0.5 * m_step_m * a);
    const Vec3 c = direction(point + 0.5 * m_step_m * b);
    const Vec3 d = direction(point + m_step_m * c);
    return point + m_step_m / 6 * (a + 2 * b + 2 * c + d);
  }

  const VolumePotential& m_potential;
  const SignedSurface& m_surface;
  double m_step_m;
  int m_most_steps;
};

struct End {
  Vec3 point = Vec3::Zero();
  int triangle = -1;
  double distance_m = std::numeric_limits<double>::infinity();
};

End nearest_end(const Vec3& point, const TriangleMesh& muscle, const std::vector<int>& triangles) {
  End nearest;
  for (const int t : triangles) {
    const auto& [a, b, c] = muscle.triangles[static_cast<std::size_t>(t)];
    const auto corner = [&](int node) { return muscle.vertices[static_cast<std::size_t>(node)]; };
    const ClosestOnTriangle closest = closest_on_triangle(point, corner(a), corner(b), corner(c));
    const double distance = (closest.point - point).norm();
    if (distance < nearest.distance_m) nearest = {closest.point, t, distance};
  }
  return nearest;
}

struct Start {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< unit, out of the muscle
  int triangle = -1;
};

/// `count` points that share the triangles' area evenly: in Morton order, each in the middle of its share.
std::vector<Start> starts_on(const TriangleMesh& muscle, const std::vector<int>& triangles, int count) {
  std::vector<Vec3> middles;
  std::vector<double> areas;
  for (const int t : triangles) {
    const auto& [a, b, c] = muscle.triangles[static_cast<std::size_t>(t)];
    const auto corner = [&](int node) { return muscle.vertices[static_cast<std::size_t>(node)]; };
    middles.emplace_back((corner(a) + corner(b) + corner(c)) / 3);
    areas.push_back(0.5 * (corner(b) - corner(a)).cross(corner(c) - corner(a)).norm());
  }
  const double total = std::accumulate(areas.begin(), areas.end(), 0.0);
  std::vector<Start> starts;
  double passed = 0;
  for (const int index : morton_order(middles)) {
    const auto at = static_cast<std::size_t>(index);
    const double before = passed;
    passed += areas[at];
    while (starts.size() < static_cast<std::size_t>(count)) {
      const double wanted = total * (static_cast<double>(starts.size()) + 0.5) / count;
      if (!(wanted < passed)) break;
      // Of several on one triangle each has a line of its own between a corner and the opposite edge.
      const double along = (wanted - before) / (passed - before);
      const Triangle& nodes = muscle.triangles[static_cast<std::size_t>(triangles[at])];
      const auto corner = [&](std::size_t i) { return muscle.vertices[static_cast<std::size_t>(nodes[i])]; };
      const Vec3 on_edge = corner(1) + along * (corner(2) - corner(1));
      const Vec3 point = corner(0) + 2.0 / 3 * (on_edge - corner(0));
      const Vec3 normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
      starts.push_back({point, normal, triangles[at]});
    }
  }
  return starts;
}

std::vector<Vec3> resampled(const std::vector<Vec3>& line, int segments) {
  std::vector<double> passed{0};
  for (std::size_t i = 1; i < line.size(); ++i) passed.push_back(passed.back() + (line[i] - line[i - 1]).norm());
  std::vector<Vec3> points{line.front()};
  std::size_t segment = 1;
  for (int i = 1; i < segments; ++i) {
    const double wanted = passed.back() * i / segments;
    while (segment + 1 < line.size() && passed[segment] < wanted) ++segment;
    const double length = passed[segment] - passed[segment - 1];
    const double share = length > 0 ? (wanted - passed[segment - 1]) / length : 0;
    points.push_back(line[segment - 1] + share * (line[segment] - line[segment - 1]));
  }
  points.push_back(line.back());
  return points;
}

}  // namespace

FibrePaths trace_fibres(const VolumePotential& potential, const TriangleMesh& muscle, const SignedSurface& surface,
                        const FibreAreas& areas, int count, int segments) {
  const Tracer tracer(potential, muscle, surface);
  const double farthest_m = farthest_end_cells * potential.cell_size_m();
  std::vector<char> is_insertion(muscle.triangles.size(), 0);
  for (const int triangle : areas.insertion) is_insertion[static_cast<std::size_t>(triangle)] = 1;
  FibrePaths paths;
  for (const Start& start : potential.flows() ? starts_on(muscle, areas.origin, count) : std::vector<Start>{}) {
    const Vec3 below = start.point - first_cells * potential.cell_size_m() * start.normal;
    std::vector<Vec3> line = tracer.trace(tracer.kept_inside(below), is_insertion);
    const End insertion = nearest_end(line.back(), muscle, areas.insertion);
    if (!(insertion.distance_m <= farthest_m)) continue;
    line.insert(line.begin(), start.point);
    line.push_back(insertion.point);
    paths.fibres.push_back({resampled(line, segments), start.triangle, insertion.triangle});
  }
  paths.lost = count - static_cast<int>(paths.fibres.size());
  return paths;
}

}  // namespace musclebench

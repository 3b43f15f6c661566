#include "core/fibres/fibre_paths.hpp"

#include <algorithm>
#include <limits>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// Of a cell: how far a streamline goes at a time.
constexpr double step_cells = 0.5;
/// A streamline that ends farther than this from its area, in cells, has lost its way.
constexpr double farthest_end_cells = 4;
/// So near to an area the flow is that of the grid: the rest of a streamline is straight.
constexpr double last_cells = 1.5;

class Tracer {
 public:
  Tracer(const VolumePotential& potential, const TriangleMesh& muscle, const SignedSurface& surface)
      : m_potential(potential),
        m_surface(surface),
        m_step_m(step_cells * potential.cell_size_m()),
        m_most_steps(static_cast<int>(20 * bounding_box(muscle.vertices).diagonal().norm() / m_step_m)) {}

  /// From `seed` to near an area. `sense`: 1 towards the insertion, -1 towards the origin.
  [[nodiscard]] std::vector<Vec3> trace(const Vec3& seed, double sense) const {
    const double end = sense > 0 ? 1 : 0;
    std::vector<Vec3> points;
    Vec3 point = seed;
    double potential = m_potential.at(seed).potential;
    for (int step = 0; step < m_most_steps; ++step) {
      const Vec3 next = kept_inside(advanced(point, sense));
      const double there = m_potential.at(next).potential;
      // Beside a wall a streamline may slide along it, but it never turns back.
      if (!(sense * (there - potential) > 0)) break;
      points.push_back(next);
      const double steps_left = (end - there) / (there - potential);
      if (steps_left * step_cells < last_cells) break;
      point = next;
      potential = there;
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
  [[nodiscard]] Vec3 direction(const Vec3& point, double sense) const {
    const Vec3 flow = m_potential.at(point).flow;
    const double speed = flow.norm();
    return speed > 0 ? Vec3(sense * flow / speed) : Vec3::Zero();
  }

  /// By the classical Runge-Kutta method.
  [[nodiscard]] Vec3 advanced(const Vec3& point, double sense) const {
    const Vec3 a = direction(point, sense);
    const Vec3 b = direction(point + 0.5 * m_step_m * a, sense);
    const Vec3 c = direction(point + 0.5 * m_step_m * b, sense);
    const Vec3 d = direction(point + m_step_m * c, sense);
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
  FibrePaths paths;
  for (const Vec3& middle : potential.seeds(count)) {
    const Vec3 seed = tracer.kept_inside(middle);
    std::vector<Vec3> line = tracer.trace(seed, -1);
    std::reverse(line.begin(), line.end());
    line.push_back(seed);
    const std::vector<Vec3> onwards = tracer.trace(seed, 1);
    line.insert(line.end(), onwards.begin(), onwards.end());
    const End origin = nearest_end(line.front(), muscle, areas.origin);
    const End insertion = nearest_end(line.back(), muscle, areas.insertion);
    if (!(origin.distance_m <= farthest_m && insertion.distance_m <= farthest_m)) continue;
    line.insert(line.begin(), origin.point);
    line.push_back(insertion.point);
    paths.fibres.push_back({resampled(line, segments), origin.triangle, insertion.triangle});
  }
  paths.lost = count - static_cast<int>(paths.fibres.size());
  return paths;
}

}  // namespace musclebench

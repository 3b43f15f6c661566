#include "core/fibres/fibre_segments.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/fibres/surface_laplace.hpp"

namespace musclebench {

namespace {

/// The harmonic function of the surface with the given boundary values; empty where the system has no unique solution.
std::vector<double> harmonic_function(const TriangleMesh& mesh, const std::vector<int>& origin,
                                      const std::vector<int>& insertion) {
  std::vector<double> values(mesh.vertices.size(), std::numeric_limits<double>::quiet_NaN());
  for (const int node : origin) {
    values[node] = 0;
  }
  for (const int node : insertion) {
    values[node] = 1;
  }
  // Positive and bounded weights give a maximum principle (no extrema inside) on any triangulation.
  return solve_on_surface(mesh, std::move(values), {}, {0.01, 100.0});
}

/// Unit gradient of a function that is linear on the triangle; zero where it is constant.
Vec3 gradient_direction(const std::array<Vec3, 3>& corners, const std::array<double, 3>& values) {
  const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  Vec3 gradient = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    gradient += values[k] * normal.cross(corners[(k + 2) % 3] - corners[(k + 1) % 3]);
  }
  const double norm = gradient.norm();
  return norm > 0 ? Vec3(gradient / norm) : Vec3::Zero();
}

}  // namespace

std::vector<FibreSegment> fibres_between(const TriangleMesh& muscle, const std::vector<int>& origin,
                                         const std::vector<int>& insertion, int most_segments) {
  if (origin.empty() || insertion.empty()) {
    return {};
  }
  const std::vector<double> values = harmonic_function(muscle, origin, insertion);
  if (values.empty()) {
    return {};
  }
  std::vector<FibreSegment> fibres;
  for (const Triangle& triangle : muscle.triangles) {
    const std::array<double, 3> at = {values[triangle[0]], values[triangle[1]], values[triangle[2]]};
    const auto [least, largest] = std::minmax({at[0], at[1], at[2]});
    if (!(largest - least > 1e-9)) {
      continue;
    }
    const std::array<Vec3, 3> corners = {muscle.vertices[triangle[0]], muscle.vertices[triangle[1]],
                                         muscle.vertices[triangle[2]]};
    const Vec3 centre = (corners[0] + corners[1] + corners[2]) / 3;
    const Vec3 half = 0.5 * (corners[1] - corners[0]).norm() * gradient_direction(corners, at);
    fibres.push_back({centre - half, centre + half});
  }
  const std::size_t step = (fibres.size() + static_cast<std::size_t>(most_segments) - 1) /
                           static_cast<std::size_t>(std::max(1, most_segments));
  std::vector<FibreSegment> thinned;
  for (std::size_t i = 0; i < fibres.size(); i += std::max<std::size_t>(1, step)) {
    thinned.push_back(fibres[i]);
  }
  return thinned;
}

}  // namespace musclebench

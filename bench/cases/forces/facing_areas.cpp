#include "bench/cases/forces/facing_areas.hpp"

#include <algorithm>
#include <numeric>

namespace musclebench {

namespace {

/// Of the triangles about a vertex: a corner of a box has a third of them on each side. A push that looks past all of
/// them would have no area.
constexpr double least_facing = 0.25;

}  // namespace

FacingAreas::FacingAreas(std::size_t vertices, std::span<const Triangle> triangles)
    : m_all(triangles), m_first(vertices + 1, 0), m_triangles(3 * triangles.size()) {
  for (const Triangle& triangle : triangles) {
    for (const int vertex : triangle) ++m_first[static_cast<std::size_t>(vertex) + 1];
  }
  std::partial_sum(m_first.begin(), m_first.end(), m_first.begin());
  std::vector<std::size_t> next(m_first.begin(), m_first.end() - 1);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const int vertex : triangles[t]) m_triangles[next[static_cast<std::size_t>(vertex)]++] = t;
  }
}

double FacingAreas::about_m2(int vertex, const Vec3& push, std::span<const Vec3> positions_m) const {
  const auto at = [&](int corner) -> const Vec3& { return positions_m[static_cast<std::size_t>(corner)]; };
  const Vec3 inward = push.stableNormalized();
  double area_m2 = 0;
  double whole_m2 = 0;
  const auto index = static_cast<std::size_t>(vertex);
  for (std::size_t i = m_first[index]; i < m_first[index + 1]; ++i) {
    const auto& [a, b, c] = m_all[m_triangles[i]];
    const Vec3 sixth_m2 = (at(b) - at(a)).cross(at(c) - at(a)) / 6;
    area_m2 += std::max(0.0, -inward.dot(sixth_m2));
    whole_m2 += sixth_m2.norm();
  }
  return std::max(area_m2, least_facing * whole_m2);
}

}  // namespace musclebench

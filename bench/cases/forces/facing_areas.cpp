#include "bench/cases/forces/facing_areas.hpp"

#include <algorithm>

namespace musclebench {

namespace {

/// Of the triangles about a vertex: a corner of a box has a third of them on each side. A push that looks past all of
/// them would have no area.
constexpr double least_facing = 0.25;

}  // namespace

FacingAreas::FacingAreas(std::size_t vertices, std::span<const Triangle> triangles)
    : m_triangles(triangles), m_around(triangles, vertices) {}

double FacingAreas::about_m2(int vertex, const Vec3& push, std::span<const Vec3> positions_m) const {
  const auto at = [&](int corner) -> const Vec3& { return positions_m[static_cast<std::size_t>(corner)]; };
  const Vec3 inward = push.stableNormalized();
  double area_m2 = 0;
  double whole_m2 = 0;
  for (const std::size_t t : m_around.of(vertex)) {
    const auto& [a, b, c] = m_triangles[t];
    const Vec3 sixth_m2 = (at(b) - at(a)).cross(at(c) - at(a)) / 6;
    area_m2 += std::max(0.0, -inward.dot(sixth_m2));
    whole_m2 += sixth_m2.norm();
  }
  return std::max(area_m2, least_facing * whole_m2);
}

}  // namespace musclebench

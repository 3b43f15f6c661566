#include "backends/bvh/exact_surface.hpp"

#include <algorithm>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

RepairedMesh moved(RepairedMesh surface, const Vec3& by) {
  for (Vec3& vertex : surface.mesh.vertices) {
    vertex += by;
  }
  return surface;
}

/// What a list reaches beyond the closest triangle, in sizes of a triangle: less is used up sooner, more is longer to
/// go through.
constexpr double list_reach = 1.5;

}  // namespace

ExactSurface::ExactSurface(const RepairedMesh& surface, int threads)
    : ExactSurface(surface, bounding_box(surface.mesh.vertices), threads) {}

ExactSurface::ExactSurface(const RepairedMesh& surface, const Eigen::AlignedBox3d& box, int threads)
    : m_centre_m(box.center()),
      m_half_extents_m((box.max() - m_centre_m).cwiseMax(m_centre_m - box.min())),
      m_near_m(mean_triangle_size_m(surface.mesh)),
      m_touching_m(touching_distance_m(surface.mesh)),
      m_surface(moved(surface, -m_centre_m)) {
  if (m_surface.closed()) {
    m_clearances =
        ClearanceGrid(m_surface, Eigen::AlignedBox3d(-m_half_extents_m, m_half_extents_m), m_near_m, threads);
  }
}

bool ExactSurface::is_outside(const Vec3& point, double& clearance_m) const {
  clearance_m = 0;
  if (!is_searchable(point)) {
    return true;
  }
  // The inside of an open surface may reach out of its box.
  if (!m_surface.closed()) {
    return false;
  }
  const Vec3 place = point - m_centre_m;
  const Vec3 beyond = place.cwiseAbs() - m_half_extents_m;
  clearance_m = std::max(beyond.cwiseMax(0).norm(), m_clearances.clearance_m(place));
  return clearance_m > 0;
}

ClosestPoint ExactSurface::closest(const Vec3& point) const {
  return m_surface.tree().closest_point(point - m_centre_m).value();
}

ClosestPoint ExactSurface::closest_from(const Vec3& point, int triangle) const {
  return m_surface.tree().closest_point_from(point - m_centre_m, triangle);
}

void ExactSurface::list_candidates(const Vec3& point, double bound_m, CandidateLeaves& list) const {
  m_surface.tree().list_candidate_leaves(point - m_centre_m, bound_m + list_reach * m_near_m, list);
}

Clearance ExactSurface::clearance_from(const Vec3& point, int triangle) const {
  return m_surface.tree().clearance_from(point - m_centre_m, triangle);
}

bool ExactSurface::contains(const Vec3& point, const ClosestPoint& closest) const {
  return closest.distance_m > m_touching_m && m_surface.is_inside(point - m_centre_m, closest);
}

Vec3 ExactSurface::outward(const Vec3& point, const ClosestPoint& closest) const {
  return m_surface.outward(point - m_centre_m, {closest, true});
}

}  // namespace musclebench

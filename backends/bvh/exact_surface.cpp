#include "backends/bvh/exact_surface.hpp"

#include <algorithm>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

RepairedMesh translated(RepairedMesh surface, const Vec3& offset) {
  for (Vec3& vertex : surface.mesh.vertices) {
    vertex += offset;
  }
  return surface;
}

/// Skin of a candidate list, in mean triangle sizes: the list covers this much more than the closest triangle. A
/// thinner one expires sooner, a thicker one holds more triangles to test.
constexpr double list_skin = 1.5;

}  // namespace

ExactSurface::ExactSurface(const RepairedMesh& surface, int threads)
    : ExactSurface(surface, bounding_box(surface.mesh.vertices), threads) {}

ExactSurface::ExactSurface(const RepairedMesh& surface, const Eigen::AlignedBox3d& box, int threads)
    : m_centre_m(box.center()),
      m_half_extents_m((box.max() - m_centre_m).cwiseMax(m_centre_m - box.min())),
      m_near_m(mean_triangle_size_m(surface.mesh)),
      m_touching_m(touching_distance_m(surface.mesh)),
      m_surface(translated(surface, -m_centre_m)) {
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
  // The inside of an open surface (winding number > 0.5) may extend beyond its bounding box.
  if (!m_surface.closed()) {
    return false;
  }
  const Vec3 local = point - m_centre_m;
  const Vec3 outside_box = (local.cwiseAbs() - m_half_extents_m).cwiseMax(0);
  clearance_m = std::max(outside_box.norm(), m_clearances.clearance_m(local));
  return clearance_m > 0;
}

ClosestPoint ExactSurface::closest(const Vec3& point, int triangle) const {
  const Vec3 local = point - m_centre_m;
  return triangle < 0 ? m_surface.tree().closest_point(local).value()
                      : m_surface.tree().closest_point_from(local, triangle);
}

void ExactSurface::list_candidates(const Vec3& point, double bound_m, CandidateLeaves& list) const {
  m_surface.tree().list_candidate_leaves(point - m_centre_m, bound_m + list_skin * m_near_m, list);
}

Clearance ExactSurface::clearance(const Vec3& point, int triangle) const {
  return m_surface.tree().clearance_from(point - m_centre_m, triangle);
}

PointSide ExactSurface::side(const Vec3& point, const ClosestPoint& closest) const {
  if (!(closest.distance_m > m_touching_m)) {
    return {};
  }
  if (m_surface.is_inside(point - m_centre_m, closest)) {
    return {.inside = true};
  }
  // Across a hole the side changes in empty space, so that the distance is no clearance.
  return {.inside = false, .clearance_m = closed() ? closest.distance_m : 0};
}

Vec3 ExactSurface::outward(const Vec3& point, const ClosestPoint& closest) const {
  return m_surface.outward(point - m_centre_m, {closest, true});
}

}  // namespace musclebench

#include "backends/bvh/exact_surface.hpp"

#include <algorithm>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// A box within so many diagonals of the origin leaves its coordinates all but a few bits.
constexpr double near_diagonals = 16;

Vec3 origin_for(const Eigen::AlignedBox3d& box) {
  const bool near = box.center().cwiseAbs().maxCoeff() <= near_diagonals * box.diagonal().norm();
  return near ? Vec3::Zero() : Vec3(box.center());
}

/// With the bone's rest frame as its own the surface is the one that others share.
std::shared_ptr<const SignedSurface> surface_about(const Vec3& origin_m, const Bone& bone) {
  if (origin_m.isZero(0)) return bone.kept_signed_distance();
  RepairedMesh moved = bone.surface;
  for (Vec3& vertex : moved.mesh.vertices) {
    vertex -= origin_m;
  }
  return std::make_shared<const SignedSurface>(moved);
}

/// Skin of a candidate list, in mean triangle sizes: the list covers this much more than the closest triangle. A
/// thinner one expires sooner, a thicker one holds more triangles to test.
constexpr double list_skin = 1.5;

}  // namespace

ExactSurface::ExactSurface(const Bone& bone, int threads)
    : ExactSurface(bone, bounding_box(bone.surface.mesh.vertices), threads) {}

ExactSurface::ExactSurface(const Bone& bone, const Eigen::AlignedBox3d& box, int threads)
    : m_origin_m(origin_for(box)),
      m_box(box.min() - m_origin_m, box.max() - m_origin_m),
      m_near_m(mean_triangle_size_m(bone.surface.mesh)),
      m_touching_m(touching_distance_m(bone.surface.mesh)),
      m_surface(surface_about(m_origin_m, bone)) {
  if (m_surface->closed()) {
    m_clearances = ClearanceGrid(*m_surface, m_box, m_near_m, threads);
  }
}

bool ExactSurface::is_outside(const Vec3& point, double& clearance_m) const {
  clearance_m = 0;
  if (!is_searchable(point)) {
    return true;
  }
  // The inside of an open surface (winding number > 0.5) may extend beyond its bounding box.
  if (!m_surface->closed()) {
    return false;
  }
  const Vec3 local = point - m_origin_m;
  clearance_m = std::max(m_box.exteriorDistance(local), m_clearances.clearance_m(local));
  return clearance_m > 0;
}

ClosestPoint ExactSurface::closest(const Vec3& point, int triangle) const {
  const Vec3 local = point - m_origin_m;
  return triangle < 0 ? m_surface->tree().closest_point(local).value()
                      : m_surface->tree().closest_point_from(local, triangle);
}

void ExactSurface::list_candidates(const Vec3& point, double bound_m, CandidateLeaves& list) const {
  m_surface->tree().list_candidate_leaves(point - m_origin_m, bound_m + list_skin * m_near_m, list);
}

Clearance ExactSurface::clearance(const Vec3& point, int triangle) const {
  return m_surface->tree().clearance_from(point - m_origin_m, triangle);
}

PointSide ExactSurface::side(const Vec3& point, const ClosestPoint& closest) const {
  if (!(closest.distance_m > m_touching_m)) {
    return {};
  }
  if (m_surface->is_inside(point - m_origin_m, closest)) {
    return {.inside = true};
  }
  // Across a hole the side changes in empty space, so that the distance is no clearance.
  return {.inside = false, .clearance_m = closed() ? closest.distance_m : 0};
}

Vec3 ExactSurface::outward(const Vec3& point, const ClosestPoint& closest) const {
  return m_surface->outward(point - m_origin_m, {closest, true});
}

}  // namespace musclebench

#include "backends/bvh/centred_surface.hpp"

namespace musclebench {

namespace {

Eigen::AlignedBox3d box_of(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& vertex : mesh.vertices) {
    box.extend(vertex);
  }
  return box;
}

RepairedMesh moved(RepairedMesh surface, const Vec3& by) {
  for (Vec3& vertex : surface.mesh.vertices) {
    vertex += by;
  }
  return surface;
}

}  // namespace

CentredSurface::CentredSurface(const RepairedMesh& surface) : CentredSurface(surface, box_of(surface.mesh)) {}

CentredSurface::CentredSurface(const RepairedMesh& surface, const Eigen::AlignedBox3d& box)
    : m_centre_m(box.center()),
      m_half_extents_m((box.max() - m_centre_m).cwiseMax(m_centre_m - box.min())),
      m_surface(moved(surface, -m_centre_m)) {}

bool CentredSurface::penetrates(const Vec3& rest_point, Penetration& found) const {
  const Vec3 point = rest_point - m_centre_m;
  // Written so that what is not a number is outside.
  const bool in_box = (point.cwiseAbs().array() <= m_half_extents_m.array()).all();
  // The inside of an open surface may reach out of its box.
  if (!in_box && (m_surface.closed() || !point.allFinite())) {
    return false;
  }
  const std::optional<SignedPoint> place = m_surface.locate_inside(point);
  if (place) {
    found = {place->closest.distance_m, m_surface.outward(point, *place)};
  }
  return place.has_value();
}

}  // namespace musclebench

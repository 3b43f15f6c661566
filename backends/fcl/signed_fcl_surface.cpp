#include "backends/fcl/signed_fcl_surface.hpp"

#include <cmath>
#include <limits>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// A closest point is a sum of three places, each rounded to the digits that the largest coordinate leaves; twice that
/// for the two that are compared.
double rounding_of(const Eigen::AlignedBox3d& box) {
  constexpr double units = 16;
  return box.isEmpty() ? 0
                       : units * std::numeric_limits<double>::epsilon() *
                             box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
}

}  // namespace

SignedFclSurface::SignedFclSurface(const RepairedMesh& surface)
    : m_sides(surface),
      m_box(bounding_box(surface.mesh.vertices)),
      m_touching_m(touching_distance_m(surface.mesh)),
      m_rounding_m(m_touching_m + rounding_of(m_box)) {}

bool SignedFclSurface::is_outside(const Vec3& point, double& clearance_m) const {
  clearance_m = 0;
  if (!point.allFinite() || m_box.isEmpty()) {
    return true;
  }
  clearance_m = m_box.exteriorDistance(point);
  return clearance_m > 0;
}

double SignedFclSurface::distance_m(const Vec3& point, int triangle) const {
  return std::sqrt(closest_on(point, triangle).squared_distance_m2);
}

bool SignedFclSurface::contains(const Vec3& point, const ClosestPoint& closest) const {
  return closest.distance_m > m_touching_m && m_sides.is_inside(point, closest);
}

Vec3 SignedFclSurface::outward(const Vec3& point, const ClosestPoint& closest) const {
  return (closest.point - point) / (closest.point - point).norm();
}

}  // namespace musclebench

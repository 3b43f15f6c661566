#include "core/signed_distance/signed_surface.hpp"

#include <algorithm>
#include <vector>

#include "core/mesh/mesh_edges.hpp"

namespace musclebench {

namespace {

/// Bound of the rounding error of a position, relative to its largest coordinate.
constexpr double relative_rounding = 1e-13;

}  // namespace

bool is_closed(TriangleMesh mesh) {
  const std::vector<int> first = first_at_position(mesh.vertices);
  for (Triangle& triangle : mesh.triangles) {
    for (int& vertex : triangle) {
      vertex = first[static_cast<std::size_t>(vertex)];
    }
  }
  const MeshEdges edges(mesh);
  for (int edge = 0; edge < edges.count(); ++edge) {
    int balance = 0;
    for (const EdgeUse& use : edges.uses(edge)) {
      balance += use.forward ? 1 : -1;
    }
    if (balance != 0) {
      return false;
    }
  }
  return true;
}

SignedSurface::SignedSurface(const RepairedMesh& surface) : m_tree(surface.mesh), m_closed(is_closed(surface.mesh)) {
  if (m_closed) {
    m_signs.emplace(Signs{ManifoldFeatures(surface.mesh, m_tree), PseudoNormals(surface.mesh)});
  }
  for (const Vec3& vertex : surface.mesh.vertices) {
    m_reach_m = std::max(m_reach_m, vertex.cwiseAbs().maxCoeff());
  }
}

SignedPoint SignedSurface::locate(const Vec3& point) const {
  SignedPoint result;
  result.closest = m_tree.closest_point(point).value();
  result.inside = is_inside(point, result.closest);
  return result;
}

std::optional<SignedPoint> SignedSurface::locate_inside(const Vec3& point) const {
  if (!m_signs && !(m_tree.winding_number(point) > 0.5)) {
    return std::nullopt;
  }
  SignedPoint result;
  result.closest = m_tree.closest_point(point).value();
  result.inside = m_signs ? is_inside(point, result.closest) : result.closest.distance_m > 0;
  return result.inside ? std::optional(result) : std::nullopt;
}

std::optional<double> SignedSurface::distance(const Vec3& point, double max_distance_m) const {
  const std::optional<ClosestPoint> closest = m_tree.closest_point(point, max_distance_m);
  if (!closest) {
    return std::nullopt;
  }
  return is_inside(point, *closest) ? -closest->distance_m : closest->distance_m;
}

Vec3 SignedSurface::outward(const Vec3& point, const SignedPoint& located) const {
  const ClosestPoint& closest = located.closest;
  if (closest.distance_m > relative_rounding * m_reach_m) {
    const Vec3 direction = located.inside ? Vec3(closest.point - point) : Vec3(point - closest.point);
    return direction / closest.distance_m;
  }
  const Vec3 of_face = m_tree.area_normal(closest.triangle);
  const bool manifold = m_signs && m_signs->manifold.holds(closest.triangle, closest.feature);
  const Vec3 of_feature = manifold ? normal_at(closest) : of_face;
  for (const Vec3& direction : {of_feature, of_face}) {
    // Scaled first, so that the squared normal of a tiny triangle does not underflow.
    const double size = direction.cwiseAbs().maxCoeff();
    if (size > 0) {
      return (direction / size).normalized();
    }
  }
  return Vec3::UnitZ();
}

}  // namespace musclebench

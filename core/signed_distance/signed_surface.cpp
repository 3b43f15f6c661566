#include "core/signed_distance/signed_surface.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/mesh/mesh_edges.hpp"

namespace musclebench {

namespace {

/// Bound of the rounding error of a position, relative to its largest coordinate.
constexpr double relative_rounding = 1e-13;

bool is_balanced(const MeshEdges& edges) {
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

/// Edges that cancel still do so when vertices are merged; others may.
bool is_closed(const TriangleMesh& mesh, const MeshEdges& edges) {
  if (is_balanced(edges)) {
    return true;
  }
  TriangleMesh merged = mesh;
  const std::vector<int> first = first_at_position(mesh.vertices);
  for (Triangle& triangle : merged.triangles) {
    for (int& vertex : triangle) {
      vertex = first[static_cast<std::size_t>(vertex)];
    }
  }
  return is_balanced(MeshEdges(merged));
}

}  // namespace

bool is_closed(const TriangleMesh& mesh) { return is_closed(mesh, MeshEdges(mesh)); }

SignedSurface::SignedSurface(const RepairedMesh& surface, TriangleBvh tree) : m_tree(std::move(tree)) {
  const MeshEdges edges(surface.mesh);
  m_closed = is_closed(surface.mesh, edges);
  if (m_closed) {
    m_signs.emplace(Signs{ManifoldFeatures(surface.mesh, m_tree, edges), PseudoNormals(surface.mesh)});
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

#pragma once

#include <optional>

#include "core/geometry/pseudo_normals.hpp"
#include "core/geometry/repair_mesh.hpp"
#include "core/geometry/triangle_tree.hpp"

namespace musclebench {

/// The exact signed distance that the fields are made from: closest triangle by a tree; sign by pseudo-normals where
/// the surface is clean, by the winding number where it is not (a doubled sheet has no pseudo-normal).
class SignedSurface {
 public:
  explicit SignedSurface(const RepairedMesh& surface) : m_tree(surface.mesh) {
    if (surface.clean) {
      m_normals.emplace(surface.mesh);
    }
  }

  [[nodiscard]] const TriangleTree& tree() const { return m_tree; }

  /// Whether `point` is inside, given its closest point.
  [[nodiscard]] bool is_inside(const Vec3& point, const ClosestPoint& closest) const {
    return m_normals ? m_normals->is_inside(point, closest.point, closest.triangle, closest.feature)
                     : m_tree.winding_number(point) > 0.5;
  }

  /// Negative inside, in metres; nothing where the surface is farther than `max_distance_m`.
  [[nodiscard]] std::optional<double> distance(const Vec3& point, double max_distance_m) const {
    const std::optional<ClosestPoint> closest = m_tree.closest_point(point, max_distance_m);
    if (!closest) {
      return std::nullopt;
    }
    return is_inside(point, *closest) ? -closest->distance_m : closest->distance_m;
  }

 private:
  TriangleTree m_tree;
  std::optional<PseudoNormals> m_normals;
};

}  // namespace musclebench

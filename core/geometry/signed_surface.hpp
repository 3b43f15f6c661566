#pragma once

#include <cstddef>
#include <limits>
#include <optional>

#include "core/geometry/pseudo_normals.hpp"
#include "core/geometry/repair_mesh.hpp"
#include "core/geometry/triangle_tree.hpp"

namespace musclebench {

/// Where a point stands to a surface.
struct SignedPoint {
  ClosestPoint closest;
  bool inside = false;

  /// In metres, negative inside.
  [[nodiscard]] double signed_distance_m() const { return inside ? -closest.distance_m : closest.distance_m; }
};

/// Exact signed distance to a surface: closest triangle by a tree; sign by pseudo-normals where the surface is clean,
/// by the winding number (inside is > 0.5) where it is not (a doubled sheet has no pseudo-normal). A point of the
/// surface is outside. Queries are const and safe from several threads.
class SignedSurface {
 public:
  explicit SignedSurface(const RepairedMesh& surface);

  [[nodiscard]] const TriangleTree& tree() const { return m_tree; }

  /// Whether the directed edges of all triangles cancel (vertices at equal positions count as one): then nothing
  /// outside the surface's box is inside.
  [[nodiscard]] bool closed() const { return m_closed; }

  /// Whether `point` is inside, given its closest point.
  [[nodiscard]] bool is_inside(const Vec3& point, const ClosestPoint& closest) const {
    return m_normals ? m_normals->is_inside(point, closest.point, closest.triangle, closest.feature)
                     : closest.distance_m > 0 && m_tree.winding_number(point) > 0.5;
  }

  /// `point` is finite, the surface has triangles.
  [[nodiscard]] SignedPoint locate(const Vec3& point) const;

  /// What `locate` says of a point that is inside; nothing of one that is outside. Cheaper than `locate` where the
  /// winding number gives the sign: it needs no closest point.
  [[nodiscard]] std::optional<SignedPoint> locate_inside(const Vec3& point) const;

  /// Negative inside, in metres; nothing where the surface is farther than `max_distance_m`.
  [[nodiscard]] std::optional<double> distance(const Vec3& point,
                                               double max_distance_m = std::numeric_limits<double>::infinity()) const;

  /// The unit vector that points out of the surface, given what `locate` says of `point`: along the way to the closest
  /// point; on the surface, where that way is only rounding, the pseudo-normal or the normal of the face; (0, 0, 1)
  /// where neither has a direction.
  [[nodiscard]] Vec3 outward(const Vec3& point, const SignedPoint& place) const;

  [[nodiscard]] std::size_t bytes() const { return m_tree.bytes() + (m_normals ? m_normals->bytes() : 0); }

 private:
  TriangleTree m_tree;
  std::optional<PseudoNormals> m_normals;
  double m_reach_m = 0;  ///< largest coordinate: what positions are rounded by
  bool m_closed = false;
};

}  // namespace musclebench

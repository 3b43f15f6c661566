#pragma once

#include <cstddef>
#include <limits>
#include <optional>

#include "core/bvh/triangle_bvh.hpp"
#include "core/distance/pseudo_normals.hpp"
#include "core/mesh_repair/repair_mesh.hpp"
#include "core/signed_distance/manifold_features.hpp"

namespace musclebench {

/// Where a point stands to a surface.
struct SignedPoint {
  ClosestPoint closest;
  bool inside = false;

  /// In metres, negative inside.
  [[nodiscard]] double signed_distance_m() const { return inside ? -closest.distance_m : closest.distance_m; }
};

/// Whether the directed edges of all triangles cancel; vertices at equal positions count as one.
bool is_closed(const TriangleMesh& mesh);

/// Exact signed distance to a surface: closest triangle by a tree; inside is where the winding number exceeds 0.5. Next
/// to the features of the surface that are clean (`ManifoldFeatures`), nearly all of them, the pseudo-normal tells as
/// much at no cost; elsewhere (a doubled sheet has no pseudo-normal) and on a surface that is not closed the winding
/// number itself is asked. A point of the surface is outside. Queries are const and safe from several threads.
class SignedSurface {
 public:
  explicit SignedSurface(const RepairedMesh& surface) : SignedSurface(surface, TriangleBvh(surface.mesh)) {}
  /// `tree` is that of the surface.
  SignedSurface(const RepairedMesh& surface, TriangleBvh tree);

  [[nodiscard]] const TriangleBvh& tree() const { return m_tree; }

  /// `is_closed`: then nothing outside the surface's box is inside, and the side changes at the surface only (across a
  /// hole it changes in empty space).
  [[nodiscard]] bool closed() const { return m_closed; }

  /// Whether `point` is inside, given its closest point.
  [[nodiscard]] bool is_inside(const Vec3& point, const ClosestPoint& closest) const {
    if (m_signs && m_signs->clean.holds(closest.triangle, closest.feature)) {
      const Vec3 way = point - closest.point;
      const Vec3 normal = normal_at(closest);
      const double along = way.dot(normal);
      // Where the normal is nearly across the way, as at a tip like a sliver's, rounding might decide.
      if (closest.feature == Feature::face || along * along > least_share * way.squaredNorm() * normal.squaredNorm()) {
        return along < 0;
      }
    }
    return closest.distance_m > 0 && m_tree.winding_number(point) > 0.5;
  }

  /// What `is_inside` will need of a point next to that triangle begins to come from memory.
  void fetch_sign(int triangle) const {
    if (m_signs) {
      m_signs->clean.fetch(triangle);
    }
  }

  /// `point` is finite, the surface has triangles.
  [[nodiscard]] SignedPoint locate(const Vec3& point) const;

  /// What `locate` says of a point that is inside; nothing of one that is outside. Cheaper than `locate` on a surface
  /// that is not closed: the winding number gives the sign, and needs no closest point.
  [[nodiscard]] std::optional<SignedPoint> locate_inside(const Vec3& point) const;

  /// Negative inside, in metres; nothing where the surface is farther than `max_distance_m`.
  [[nodiscard]] std::optional<double> distance(const Vec3& point,
                                               double max_distance_m = std::numeric_limits<double>::infinity()) const;

  /// The unit vector that points out of the surface, given what `locate` says of `point`: along the way to the closest
  /// point; on the surface, where that way is only rounding, the pseudo-normal or the normal of the face; (0, 0, 1)
  /// where neither has a direction.
  [[nodiscard]] Vec3 outward(const Vec3& point, const SignedPoint& place) const;

  [[nodiscard]] std::size_t bytes() const { return m_tree.bytes() + (m_signs ? m_signs->bytes() : 0); }

 private:
  /// What gives the sign of a closed surface without a winding number.
  struct Signs {
    ManifoldFeatures clean;
    PseudoNormals normals;
    [[nodiscard]] std::size_t bytes() const { return clean.bytes() + normals.bytes(); }
  };
  /// Square of the least cosine between a way and a pseudo-normal that is believed.
  static constexpr double least_share = 1e-12;

  /// Of any length; of a face by the corners, which the closest point has just used.
  [[nodiscard]] Vec3 normal_at(const ClosestPoint& closest) const {
    return closest.feature == Feature::face ? m_tree.area_normal(closest.triangle)
                                            : m_signs->normals.at(closest.triangle, closest.feature);
  }

  TriangleBvh m_tree;
  std::optional<Signs> m_signs;  ///< of a closed surface
  double m_reach_m = 0;          ///< largest coordinate: what positions are rounded by
  bool m_closed = false;
};

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <limits>
#include <optional>

#include "core/bvh/triangle_bvh.hpp"
#include "core/distance/pseudo_normals.hpp"
#include "core/mesh_repair/repair_mesh.hpp"
#include "core/signed_distance/manifold_features.hpp"

namespace musclebench {

/// A point's closest point on a surface, and its side.
struct SignedPoint {
  ClosestPoint closest;
  bool inside = false;

  /// Metres, negative inside.
  [[nodiscard]] double signed_distance_m() const { return inside ? -closest.distance_m : closest.distance_m; }
};

/// Whether every edge is used as often in one direction as in the other; vertices at equal positions count as one.
bool is_closed(const TriangleMesh& mesh);

/// Exact signed distance to a surface. The distance is that of the closest triangle, found by a BVH; a point is inside
/// where the generalised winding number exceeds 0.5 (Jacobson et al. 2013). Where the closest feature is manifold
/// (ManifoldFeatures; nearly all are) the angle-weighted pseudo-normal gives the same sign much faster (Baerentzen and
/// Aanaes 2005). The winding number is computed only at other features, such as a doubled sheet, and for a surface that
/// is not closed. A point on the surface is outside. Points are in the surface's frame, in metres; queries are const
/// and safe from several threads.
class SignedSurface {
 public:
  explicit SignedSurface(const RepairedMesh& surface) : SignedSurface(surface, TriangleBvh(surface.mesh)) {}
  /// `tree` is that of the surface.
  SignedSurface(const RepairedMesh& surface, TriangleBvh tree);

  [[nodiscard]] const TriangleBvh& tree() const { return m_tree; }

  /// `is_closed`: no point outside the surface's bounding box is inside, and the side changes only at the surface. (Of
  /// an open surface it also changes in empty space, across a hole.)
  [[nodiscard]] bool closed() const { return m_closed; }

  /// Whether `point` is inside, given its closest point.
  [[nodiscard]] bool is_inside(const Vec3& point, const ClosestPoint& closest) const {
    if (m_signs && m_signs->manifold.holds(closest.triangle, closest.feature)) {
      const Vec3 displacement = point - closest.point;
      const Vec3 normal = normal_at(closest);
      const double along = displacement.dot(normal);
      // Where the normal is nearly perpendicular to the displacement, as at a very sharp tip, rounding could decide.
      if (closest.feature == Feature::face ||
          along * along > least_squared_cosine * displacement.squaredNorm() * normal.squaredNorm()) {
        return along < 0;
      }
    }
    return closest.distance_m > 0 && m_tree.winding_number(point) > 0.5;
  }

  /// Prefetches what `is_inside` reads for a point closest to that triangle.
  void prefetch_sign(int triangle) const {
    if (m_signs) {
      m_signs->manifold.prefetch(triangle);
    }
  }

  /// `point` has to be finite and the surface to have triangles.
  [[nodiscard]] SignedPoint locate(const Vec3& point) const;

  /// The answer of `locate` to the bit, found faster the closer `triangle` is (TriangleBvh::closest_point_from).
  [[nodiscard]] SignedPoint locate_from(const Vec3& point, int triangle) const {
    const ClosestPoint closest = m_tree.closest_point_from(point, triangle);
    return {closest, is_inside(point, closest)};
  }

  /// The result of `locate` for a point that is inside, nothing for one that is outside. Cheaper than `locate` for an
  /// open surface, where the winding number gives the sign without a closest point.
  [[nodiscard]] std::optional<SignedPoint> locate_inside(const Vec3& point) const;

  /// Signed distance in metres, negative inside; nothing where the surface is farther than `max_distance_m`.
  [[nodiscard]] std::optional<double> distance(const Vec3& point,
                                               double max_distance_m = std::numeric_limits<double>::infinity()) const;

  /// Unit gradient of the signed distance at `point`, given the result of `locate`. On the surface, where the direction
  /// to the closest point is only rounding, the pseudo-normal or the normal of the face; (0, 0, 1) where both vanish.
  [[nodiscard]] Vec3 outward(const Vec3& point, const SignedPoint& located) const;

  [[nodiscard]] std::size_t bytes() const { return m_tree.bytes() + (m_signs ? m_signs->bytes() : 0); }

 private:
  /// The sign of a closed surface without winding numbers.
  struct Signs {
    ManifoldFeatures manifold;
    PseudoNormals normals;
    [[nodiscard]] std::size_t bytes() const { return manifold.bytes() + normals.bytes(); }
  };
  /// Below this squared cosine between displacement and pseudo-normal the sign is left to the winding number.
  static constexpr double least_squared_cosine = 1e-12;

  /// Not normalised. A face's normal is computed from its corners, which the closest-point test has just loaded.
  [[nodiscard]] Vec3 normal_at(const ClosestPoint& closest) const {
    return closest.feature == Feature::face ? m_tree.area_normal(closest.triangle)
                                            : m_signs->normals.at(closest.triangle, closest.feature);
  }

  TriangleBvh m_tree;
  std::optional<Signs> m_signs;  ///< of a closed surface
  double m_reach_m = 0;          ///< largest coordinate, which bounds the rounding of positions
  bool m_closed = false;
};

}  // namespace musclebench

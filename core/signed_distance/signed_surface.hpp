#pragma once

#include <cstddef>
#include <limits>
#include <optional>

#include "core/bvh/triangle_bvh.hpp"
#include "core/distance/pseudo_normals.hpp"
#include "core/mesh_repair/repair_mesh.hpp"
#include "core/signed_distance/manifold_features.hpp"

namespace musclebench {

/// The closest point of a surface to a query point, and the side of the query point.
struct SignedPoint {
  ClosestPoint closest;
  bool inside = false;

  /// The signed distance in metres, negative inside.
  [[nodiscard]] double signed_distance_m() const { return inside ? -closest.distance_m : closest.distance_m; }
};

/// Whether a mesh is closed: each edge is used equally often in both directions. Vertices at equal positions count as
/// one vertex.
bool is_closed(const TriangleMesh& mesh);

/// The exact signed distance to a surface, in metres, negative inside.
///
/// The distance is that of the closest triangle, which a BVH finds. A point is inside if the generalised winding number
/// exceeds 0.5 (Jacobson et al. 2013). At nearly all points the angle-weighted pseudo-normal of the closest feature
/// gives the same sign much faster (Baerentzen and Aanaes 2005). The winding number is computed only for an open
/// surface, and at features that are not manifold, such as a doubled sheet (ManifoldFeatures). A point on the surface
/// is outside.
///
/// Points are in the frame of the surface, in metres. Queries are const and safe from several threads.
class SignedSurface {
 public:
  /// Builds the tree and the signs. `surface` need not outlive this object.
  explicit SignedSurface(const RepairedMesh& surface) : SignedSurface(surface, TriangleBvh(surface.mesh)) {}
  /// The same with a tree that was built from `surface.mesh`.
  SignedSurface(const RepairedMesh& surface, TriangleBvh tree);

  [[nodiscard]] const TriangleBvh& tree() const { return m_tree; }

  /// Whether the surface is closed (`is_closed`). If so, the side of a point changes only at the surface, and no point
  /// outside its bounding box is inside. If not, the side also changes across holes.
  [[nodiscard]] bool closed() const { return m_closed; }

  /// Whether `point` is inside. `closest` must be its closest point.
  [[nodiscard]] bool is_inside(const Vec3& point, const ClosestPoint& closest) const {
    if (m_signs && m_signs->manifold.holds(closest.triangle, closest.feature)) {
      const Vec3 displacement = point - closest.point;
      const Vec3 normal = normal_at(closest);
      const double along = displacement.dot(normal);
      // If the normal is nearly perpendicular to the displacement, as at a very sharp tip, rounding could decide.
      if (closest.feature == Feature::face ||
          along * along > least_squared_cosine * displacement.squaredNorm() * normal.squaredNorm()) {
        return along < 0;
      }
    }
    return closest.distance_m > 0 && m_tree.winding_number(point) > 0.5;
  }

  /// Prefetches the memory that `is_inside` reads for a point whose closest triangle this is.
  void prefetch_sign(int triangle) const {
    if (m_signs) {
      m_signs->manifold.prefetch(triangle);
    }
  }

  /// The closest point and the side. `point` must be finite and the surface must have triangles.
  [[nodiscard]] SignedPoint locate(const Vec3& point) const;

  /// The same bits as `locate`, found faster if `triangle` is near the point (TriangleBvh::closest_point_from).
  [[nodiscard]] SignedPoint locate_from(const Vec3& point, int triangle) const {
    const ClosestPoint closest = m_tree.closest_point_from(point, triangle);
    return {closest, is_inside(point, closest)};
  }

  /// The result of `locate` if the point is inside, otherwise nothing. For an open surface this is cheaper than
  /// `locate`: the winding number needs no closest point.
  [[nodiscard]] std::optional<SignedPoint> locate_inside(const Vec3& point) const;

  /// The signed distance in metres, negative inside. Returns nothing if the surface is farther than `max_distance_m`.
  [[nodiscard]] std::optional<double> distance(const Vec3& point,
                                               double max_distance_m = std::numeric_limits<double>::infinity()) const;

  /// The unit gradient of the signed distance at `point`, which points outwards. `located` must be the result of
  /// `locate`. On the surface it is the pseudo-normal or the normal of the face. If both vanish it is (0, 0, 1).
  [[nodiscard]] Vec3 outward(const Vec3& point, const SignedPoint& located) const;

  /// Memory of the tree and the signs.
  [[nodiscard]] std::size_t bytes() const { return m_tree.bytes() + (m_signs ? m_signs->bytes() : 0); }

 private:
  /// What gives the sign of a closed surface without a winding number.
  struct Signs {
    ManifoldFeatures manifold;
    PseudoNormals normals;
    [[nodiscard]] std::size_t bytes() const { return manifold.bytes() + normals.bytes(); }
  };
  /// Below this squared cosine between displacement and pseudo-normal the winding number gives the sign.
  static constexpr double least_squared_cosine = 1e-12;

  /// Not normalised. A face's normal is computed from its corners: the closest-point test has just loaded them.
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

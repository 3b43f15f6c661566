#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/triangle_mesh.hpp"

namespace musclebench {

/// The point of a surface that is closest to a query point.
struct ClosestSurfacePoint {
  double squared_distance_m2 = std::numeric_limits<double>::infinity();
  Vec3 point_m = Vec3::Zero();  ///< relative to RefereeTree::centre_m()
  int place = -1;               ///< of the triangle, in the order of the tree; -1: none
};

/// A tree of boxes, four children a node, over the triangles of one surface: the Referee's own, shared with no backend.
///
/// All points that go in or come out are relative to `centre_m()`, the middle of the surface's box, so that a bone far
/// from the origin is judged as exactly as one at it. Boxes are held as 32-bit floats rounded outwards and serve only
/// to leave triangles out; distances and crossings are computed from the vertices in double precision.
class RefereeTree {
 public:
  /// Copies what it needs of `mesh` (at least one triangle, finite vertices, valid indices).
  explicit RefereeTree(const TriangleMesh& mesh);

  [[nodiscard]] const Vec3& centre_m() const { return m_centre; }
  [[nodiscard]] double diagonal_m() const { return 2 * m_half_extents.norm(); }

  /// True where the directed edges of all triangles cancel (vertices at equal positions count as one): only then is the
  /// winding number a whole number that changes at the surface and nowhere else.
  [[nodiscard]] bool closed() const { return m_closed; }

  /// Distance from `point` to the surface's box; 0 inside it. Never larger than the distance to the surface.
  [[nodiscard]] double box_distance(const Vec3& point) const;

  /// The closest point of the surface. Of triangles at equal distance the first in the mesh is taken, so the answer
  /// does not depend on `guess` (a place returned before, or -1), which only makes the search shorter.
  [[nodiscard]] ClosestSurfacePoint closest(const Vec3& point, int guess = -1) const;

  /// Winding number of the surface around `point`: exact where `closed()` (signed crossings of a ray), else the sum of
  /// all solid angles, which costs time in proportion to the number of triangles.
  [[nodiscard]] double winding_number(const Vec3& point) const;

  /// Unit normal of the triangle at `place`, by its winding; zero for a triangle without area.
  [[nodiscard]] Vec3 face_normal(int place) const;

  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Corners {
    Vec3 a, b, c;
    int index;    ///< in the mesh
    bool sliver;  ///< so thin that rounding can tell its inside from its outside wrongly
  };

  /// `child` is the number of a node, or ~(8 * first place + count) for a leaf. Absent children have an inverted box.
  struct Node {
    Eigen::Array4f low[3], high[3];
    int child[4];
  };

  friend class RefereeTreeBuilder;

  void consider(const Vec3& point, int place, ClosestSurfacePoint& best) const;
  [[nodiscard]] int count_crossings(const Vec3& point) const;

  std::vector<Corners> m_triangles;
  std::vector<Node> m_nodes;
  Vec3 m_centre = Vec3::Zero();
  Vec3 m_half_extents = Vec3::Zero();
  bool m_closed = false;
};

}  // namespace musclebench

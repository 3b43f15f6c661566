#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "core/mesh/triangle_mesh.hpp"
#include "core/referee/referee_sign.hpp"

namespace musclebench {

/// The point of a surface that is closest to a query point.
struct ClosestSurfacePoint {
  double squared_distance_m2 = std::numeric_limits<double>::infinity();
  Vec3 point_m = Vec3::Zero();  ///< relative to RefereeTree::centre_m()
  int slot = -1;                ///< of the triangle, in the order of the tree; -1: none
};

/// Where a segment passes through a surface.
struct SurfaceCrossing {
  double share = 0;       ///< of the segment, from its start to the crossing
  bool entering = false;  ///< from the front of the triangle to its back
  int slot = -1;          ///< of the triangle, in the order of the tree
};

/// The winding number of a surface around a point, and a bound of the movement that keeps it on its side of 0.5.
struct SurfaceWinding {
  double number = 0;
  /// The point and the vertices of the surface may move by this much together before `number` may cross 0.5, as long as
  /// the point does not pass through the surface. Infinite for a closed surface: its winding number changes nowhere
  /// else.
  double steady_m = std::numeric_limits<double>::infinity();
};

/// A tree of boxes, four children a node, over the triangles of one surface: the Referee's own, shared with no backend.
/// It duplicates much of core/bvh on purpose, although that is faster: what judges the backends may share no code with
/// them, or a defect of that code would go unseen.
///
/// All points that go in or come out are relative to `centre_m()`, the middle of the surface's box, so that a bone far
/// from the origin is judged as exactly as one at it. Boxes are held as 32-bit floats rounded outwards and only cull;
/// distances and crossings are computed from the vertices in double precision.
///
/// Queries add their cost to `work`, where one is given: one for each node visited, triangle tested and boundary edge
/// visited. It depends on the input alone, so that a budget of it gives the same answer on any machine.
class RefereeTree {
 public:
  /// Copies what it needs of `mesh` (at least one triangle, finite vertices, valid indices).
  explicit RefereeTree(const TriangleMesh& mesh);

  [[nodiscard]] const Vec3& centre_m() const { return m_centre; }
  [[nodiscard]] double diagonal_m() const { return 2 * m_half_extents.norm(); }

  /// True where the directed edges of all triangles cancel (vertices at equal positions count as one): only then is the
  /// winding number a whole number that changes at the surface and nowhere else.
  [[nodiscard]] bool closed() const { return m_boundary.empty(); }

  /// Distance from `point` to the surface's box; 0 inside it. Never larger than the distance to the surface.
  [[nodiscard]] double box_distance(const Vec3& point) const;

  /// No point inside a closed surface is farther from it than half of the box's shortest side.
  [[nodiscard]] double inradius_bound_m() const { return m_half_extents.minCoeff(); }

  /// The closest point of the surface. Of triangles at equal distance the first in the mesh is taken, so the answer
  /// does not depend on `guess` (a slot returned before, or -1), which only makes the search shorter.
  [[nodiscard]] ClosestSurfacePoint closest(const Vec3& point, int guess = -1, long* work = nullptr) const;

  /// Winding number of the surface around `point` (Jacobson et al. 2013): the signed crossings of a ray, which is exact
  /// where `closed()`; for an open surface plus the solid angles of the strips that close it along its boundary edges
  /// (see strip_share), in time proportional to their number.
  [[nodiscard]] double winding_number(const Vec3& point, long* work = nullptr) const;

  /// The same, with the movement for which the side holds.
  [[nodiscard]] SurfaceWinding winding(const Vec3& point, long* work = nullptr) const;

  /// Unit normal of the triangle at `slot`, by its winding; zero for a triangle without area.
  [[nodiscard]] Vec3 face_normal(int slot) const;

  /// Index in the mesh of the triangle at `slot`.
  [[nodiscard]] int triangle_index(int slot) const { return m_triangles[static_cast<std::size_t>(slot)].index; }

  /// Slot of a triangle of the surface that intersects the triangle (a, b, c); -1: none. Never -1 where the
  /// intersection exceeds rounding; may be a slot where the two only come that close.
  [[nodiscard]] int find_touched(const Vec3& a, const Vec3& b, const Vec3& c, long* work = nullptr) const;

  /// Indices in the mesh of the triangles in leaves that reach the box, into `triangles`, in no particular order: all
  /// triangles that touch the box, and some that lie close to it.
  void find_near_box(const Eigen::AlignedBox3d& box, std::vector<int>& triangles, long* work = nullptr) const;

  /// The crossings of the segment with the surface, into `crossings`, in the order that they are met in. A point on the
  /// surface counts as in front of it. Which triangles are crossed is decided without rounding errors; a segment
  /// through an edge crosses one of the triangles there; through a vertex it may cross any number.
  void cross(const Vec3& from, const Vec3& to, std::vector<SurfaceCrossing>& crossings, long* work = nullptr) const;

  /// Moves the vertices and keeps the tree's shape: answers stay exact, queries get slower the more the surface
  /// deforms. `triangles` and the number of `vertices` are those of the mesh that the tree was made of; `vertices` are
  /// not relative to `centre_m()`, which stays what it was.
  void refit(std::span<const Triangle> triangles, std::span<const Vec3> vertices);

  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Corners {
    Vec3 a, b, c;
    int index;    ///< in the mesh
    bool sliver;  ///< so thin that rounding can misplace a point in its plane inside or outside of it
  };

  /// An edge along which directed edges of the triangles do not cancel.
  struct BoundaryEdge {
    Vec3 from, to;
    int from_vertex, to_vertex;  ///< in the mesh
    double uses;                 ///< so many more triangles run from -> to than to -> from; positive
  };

  /// `child` is the number of a node, or ~(8 * first slot + count) for a leaf. Absent children have an inverted box.
  struct Node {
    Eigen::Array4f low[3], high[3];
    int child[4];
  };

  friend class RefereeTreeBuilder;

  /// Calls `visit_slot` for the triangles in all boxes that pass the filter `may_matter` (of a node: which of its
  /// children), until it returns false.
  template <typename Filter, typename Visit>
  void visit(const Filter& may_matter, const Visit& visit_slot, long* work) const;

  void consider(const Vec3& point, int slot, ClosestSurfacePoint& best) const;
  [[nodiscard]] int count_crossings(const Vec3& point, AxisRay ray, long* work) const;
  [[nodiscard]] AxisRay shortest_ray_out(const Vec3& point) const;

  std::vector<Corners> m_triangles;
  std::vector<Node> m_nodes;
  Vec3 m_centre = Vec3::Zero();
  Vec3 m_half_extents = Vec3::Zero();
  std::vector<BoundaryEdge> m_boundary;  // none where the surface is closed
};

}  // namespace musclebench

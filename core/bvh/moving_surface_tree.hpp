#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/bvh/moving_surface_boxes.hpp"
#include "core/bvh/triangle_bvh.hpp"
#include "core/bvh/triangle_bvh_nodes.hpp"
#include "core/mesh/body.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// An 8-wide tree of axis-aligned boxes (AABBs) over the surface of a body whose vertices move: built once, at rest,
/// and refitted, which keeps the tree's shape and gives its boxes new bounds.
///
/// Boxes are refitted only when some vertex has travelled far since the last time. In between a box is off by at most
/// the largest displacement of a vertex since then, and a search allows for that; distances are those of the vertices
/// as they are. So every answer is that of brute force to the bit, whenever the boxes were refitted: of all triangles
/// the one with the smallest squared distance by `closest_on_triangle`, of several the one with the smallest index.
///
/// Points and vertices are in the world frame, in metres. Queries are const and safe from several threads.
class MovingSurfaceTree {
 public:
  /// `mesh` is that of all bodies; the body has triangles. Only indices are kept of it.
  MovingSurfaceTree(const TriangleMesh& mesh, const Body& body);

  /// Tells where the vertices of all bodies are, before the queries about them. They are read by these, and have to
  /// stay as they are. `threads`: of a refit.
  void update(std::span<const Vec3> vertices, int threads);

  /// Of the whole mesh's triangles the closest one of this body; its `triangle` is -1 where none is closer than
  /// `max_distance_m`, and for a point that is not finite. `guess` is a triangle that may be near, or -1: it only makes
  /// the search shorter. Triangles of `left_out`, ascending, are none of those looked at.
  [[nodiscard]] ClosestPoint closest_point(const Vec3& point, int guess = -1,
                                           double max_distance_m = std::numeric_limits<double>::infinity(),
                                           std::span<const int> left_out = {}) const;

  /// The winding number of the surface, which is closed, about a point that is not on it: how often more a ray leaves
  /// through it than it enters. 1 inside, and right where the surface passes through itself, too, which the normal at
  /// the closest point is not. 0 for a point that is not finite.
  [[nodiscard]] int winding_number(const Vec3& point) const;

  /// A lower bound of the distance to the surface, by its box alone; 0 inside the box.
  [[nodiscard]] double box_distance_m(const Vec3& point) const;

  /// How often `update` has refitted the boxes.
  [[nodiscard]] int refits() const { return m_refits; }

  [[nodiscard]] std::size_t bytes() const;

 private:
  static constexpr std::size_t width = bvh_width;

  struct Node {
    MovingBoxes boxes;
    std::array<std::int32_t, width> child;  ///< index of a node, or ~index of a leaf; 0 for none
  };
  /// A triangle a lane, in a box of its own: most are left out by it.
  struct Leaf {
    MovingBoxes boxes;
    std::array<std::int32_t, width> triangle;
    std::int32_t count = 0;
  };
  struct Best;
  struct Ray;

  void refit(int threads);
  void fit_leaf(std::size_t index);
  void consider(const Vec3& point, int triangle, Best& best) const;
  [[nodiscard]] Ray shortest_ray_out(const Vec3& point) const;
  [[nodiscard]] int crossing(const Ray& ray, int triangle) const;
  /// Of a point, relative to m_origin; and what boxes may be off by for it, with the travel.
  [[nodiscard]] std::array<float, 3> to_boxes(const Vec3& point) const;
  [[nodiscard]] double margin_m(const Vec3& point) const;

  std::vector<Node> m_nodes;  ///< a parent before its children
  std::vector<Leaf> m_leaves;
  std::vector<Triangle> m_triangles;  ///< of this body, from `m_first_triangle` on
  std::size_t m_first_triangle;
  std::size_t m_first_node;
  std::vector<Vec3> m_fitted;                        ///< where the body's vertices were when the boxes were refitted
  std::vector<std::array<float, 3>> m_fitted_local;  ///< the same, relative to m_origin
  Eigen::AlignedBox3d m_box;                         ///< of m_fitted
  Vec3 m_origin = Vec3::Zero();                      ///< of the boxes: the middle of m_box
  double m_farthest_m;                               ///< a larger displacement of a vertex calls for a refit
  double m_travel_m = 0;  ///< upper bound of the displacement of any vertex since the last refit
  int m_refits = 0;
  std::span<const Vec3> m_vertices;
};

}  // namespace musclebench

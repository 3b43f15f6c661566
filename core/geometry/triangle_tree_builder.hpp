#pragma once

#include <utility>
#include <vector>

#include "core/geometry/triangle_mesh.hpp"
#include "core/geometry/triangle_tree.hpp"

namespace musclebench {

/// Builds a TriangleTree from the top: ranges of triangles are cut in two where the areas of the boxes of both parts,
/// each times its leaves, sum to the least (surface area heuristic over bins), until a node has its children.
class TriangleTreeBuilder {
 public:
  /// `mesh` has triangles; `tree` is empty.
  TriangleTreeBuilder(const TriangleMesh& mesh, TriangleTree& tree);

  void build();

 private:
  struct Box {
    Vec3 lower = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 upper = Vec3::Constant(-std::numeric_limits<double>::infinity());

    void extend(const Vec3& point) {
      lower = lower.cwiseMin(point);
      upper = upper.cwiseMax(point);
    }
    void extend(const Box& other) {
      lower = lower.cwiseMin(other.lower);
      upper = upper.cwiseMax(other.upper);
    }
    [[nodiscard]] double half_area() const {
      const Vec3 size = (upper - lower).cwiseMax(0.0);
      return size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
    }
  };
  /// Places in `m_order`.
  struct Range {
    int begin = 0;
    int end = 0;
    [[nodiscard]] int count() const { return end - begin; }
    [[nodiscard]] bool fits_leaf() const { return count() <= static_cast<int>(tree_width); }
  };

  void choose_frame();
  /// Returns what a parent's `child` holds.
  [[nodiscard]] int add(Range range, int depth);
  [[nodiscard]] int add_leaf(Range range);
  [[nodiscard]] std::pair<Range, Range> split(Range range, int depth);
  /// Returns the first place of the upper part; the range's begin or end where there is nothing to gain.
  [[nodiscard]] int split_by_area(Range range, int axis, const Box& spread);
  [[nodiscard]] TreeCluster cluster_of(Range range) const;
  void set_bounds(Range range, const Vec3& area_normal, std::size_t place, TreeNode& node) const;
  /// Returns whether the triangle is a needle.
  bool set_triangle(int triangle, std::size_t place, TreeLeaf& leaf);

  [[nodiscard]] Vec3 to_own(const Vec3& position) const { return m_tree.m_scale * (position - m_tree.m_centre_m); }
  [[nodiscard]] const std::array<Vec3, 3>& corners(int place) const {
    return m_tree.m_corners[static_cast<std::size_t>(m_order[static_cast<std::size_t>(place)])];
  }

  TriangleTree& m_tree;
  std::vector<Box> m_boxes;     ///< of each triangle
  std::vector<Vec3> m_centres;  ///< of the boxes
  std::vector<int> m_order;
};

}  // namespace musclebench

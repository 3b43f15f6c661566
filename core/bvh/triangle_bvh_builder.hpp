#pragma once

#include <utility>
#include <vector>

#include "core/bvh/triangle_bvh.hpp"
#include "core/bvh/triangle_bvh_nodes.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Builds a TriangleBvh top-down with the binned surface area heuristic (SAH): the largest range of triangles is split
/// in two until a node has its children. The cost of a range is the area of its box times the number of its leaves.
class TriangleBvhBuilder {
 public:
  /// `mesh` has triangles; `tree` is empty.
  TriangleBvhBuilder(const TriangleMesh& mesh, TriangleBvh& tree);

  void build();

 private:
  /// An AABB in the tree's frame, upper corner negated, so that both corners grow by a minimum. It only guides the
  /// splits and need not be rounded outwards.
  struct Box {
    Eigen::Array4f lower = Eigen::Array4f::Constant(bvh_far_away);
    Eigen::Array4f negated_upper = Eigen::Array4f::Constant(bvh_far_away);

    void extend(const Box& other) {
      lower = lower.min(other.lower);
      negated_upper = negated_upper.min(other.negated_upper);
    }
    [[nodiscard]] Eigen::Array4f doubled_centre() const { return lower - negated_upper; }
    [[nodiscard]] float half_area() const {
      const Eigen::Array4f size = (-negated_upper - lower).max(0.0F);
      return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
    }
  };
  /// Indices into m_order.
  struct Range {
    int begin = 0;
    int end = 0;
    [[nodiscard]] int count() const { return end - begin; }
    [[nodiscard]] bool fits_leaf() const { return count() <= static_cast<int>(bvh_width); }
  };

  void choose_frame();
  /// Adds a node (or leaf) and all below it; returns its index as BvhNode::child has it.
  [[nodiscard]] int add(Range range, int depth);
  /// Only notes the leaf: all are filled at the end, when their number is known, into memory of the right size.
  [[nodiscard]] int add_leaf(Range range);
  void fill_leaves();
  [[nodiscard]] std::pair<Range, Range> split(Range range, int depth);
  /// Returns where the upper part begins; the range's begin or end where no split is worth its cost.
  [[nodiscard]] int split_by_area(Range range, const Box& spread);
  [[nodiscard]] int halve(Range range, const Box& spread);
  [[nodiscard]] BvhCluster cluster_of(Range range) const;
  /// The unit vector perpendicular to the unit vector `normal` along which the triangles extend the most.
  [[nodiscard]] Vec3 longest_tangent(Range range, const Vec3& normal) const;
  void set_bounds(Range range, const Vec3& area_normal, std::size_t lane, BvhNode& node) const;
  /// Returns whether the triangle is a sliver.
  bool set_triangle(int triangle, std::size_t lane, BvhLeaf& leaf);

  [[nodiscard]] Vec3 to_tree_frame(const Vec3& position) const {
    return m_tree.m_scale * (position - m_tree.m_centre_m);
  }
  [[nodiscard]] const std::array<Vec3, 3>& corners(int index) const {
    return m_tree.m_corners[static_cast<std::size_t>(m_order[static_cast<std::size_t>(index)])];
  }

  [[nodiscard]] const Box& box(int index) const {
    return m_boxes[static_cast<std::size_t>(m_order[static_cast<std::size_t>(index)])];
  }

  TriangleBvh& m_tree;
  std::vector<Box> m_boxes;  ///< by triangle
  std::vector<int> m_order;  ///< triangles, those of a range together
  struct NotedLeaf {
    Range range;
    decltype(BvhLeaf::ancestors) ancestors;
  };
  std::vector<NotedLeaf> m_noted;
  std::vector<std::int32_t> m_path;  ///< from the root to the node that is being filled
};

}  // namespace musclebench

#pragma once

#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "core/referee/referee_tree.hpp"

namespace musclebench {

/// The largest 32-bit float that is not above `value`, and the smallest that is not below it.
inline float round_down(double value) {
  const auto nearest = static_cast<float>(value);
  return nearest <= value ? nearest : std::nextafter(nearest, -std::numeric_limits<float>::infinity());
}
inline float round_up(double value) { return -round_down(-value); }

inline void add_work(long* work, long steps) {
  if (work != nullptr) *work += steps;
}

/// Fills a RefereeTree: splits where the surface-area heuristic (binned, Wald 2007) expects the shortest queries.
class RefereeTreeBuilder {
 public:
  /// Nodes on the longest path from the root to a leaf: past half of it ranges are halved by count.
  static constexpr int depth_limit = 64;

  RefereeTreeBuilder(const TriangleMesh& mesh, RefereeTree& tree) : m_mesh(mesh), m_tree(tree) {}
  void build();
  /// Gives the vertices of `mesh` new positions in a tree that was built with its triangles.
  static void refit(std::span<const Triangle> triangles, std::span<const Vec3> vertices, RefereeTree& tree);

 private:
  using Box = Eigen::AlignedBox3d;
  struct Item {
    Box box;
    Vec3 middle;
    int index;
  };
  /// Items first .. last - 1.
  struct Range {
    int first, last;
    Box box;
    [[nodiscard]] int count() const { return last - first; }
  };

  void centre();
  void find_boundary();
  [[nodiscard]] Range range(int first, int last) const;
  [[nodiscard]] int split_by_area(const Range& whole);
  [[nodiscard]] std::pair<Range, Range> split(const Range& whole, int depth);
  [[nodiscard]] int add(const Range& whole, int depth);
  void copy_triangles();

  const TriangleMesh& m_mesh;
  RefereeTree& m_tree;
  std::vector<Vec3> m_vertices;
  std::vector<Item> m_items;
};

}  // namespace musclebench

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/geometry/triangle_tree.hpp"

namespace musclebench {

/// Finds the closest points of a few points that lie close together in one walk through a TriangleTree. The distance to
/// a box or a triangle is convex, so that its slope at the packet's middle bounds it from below at every point of the
/// packet: one look at a box answers for all of them, and the bound is the tighter the farther the box is. The floats
/// only prune; `closest_on_triangle` decides. So the answers are those of TriangleTree::closest_point, to the bit.
class PacketSearch {
 public:
  static constexpr std::size_t most_points = 8;

  explicit PacketSearch(const TriangleTree& tree) : m_tree(&tree) {}

  /// Answers for up to `most_points` points, each within 1e12 times the mesh's size. `seed` is any triangle; the search
  /// is fast where it is near. `answers` is as long as `points`.
  void closest_points(std::span<const Vec3> points, int seed, std::span<ClosestPoint> answers) const;

 private:
  const TriangleTree* m_tree;
};

}  // namespace musclebench

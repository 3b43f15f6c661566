#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/bvh/triangle_bvh.hpp"

namespace musclebench {

/// The part of a surface near some points, with a tree of its own: questions about few points need no tree over the
/// whole surface.
class NearbyTriangles {
 public:
  NearbyTriangles(const TriangleMesh& mesh, std::span<const Vec3> points, double margin_m);

  [[nodiscard]] double margin_m() const { return m_margin_m; }
  [[nodiscard]] std::size_t triangle_count() const { return m_triangles.size(); }
  /// The answer of `TriangleBvh::closest_point` over the whole surface to the bit, for one of the points and a
  /// `max_distance_m` of at most the margin: all triangles that are so near are here, in their order.
  [[nodiscard]] std::optional<ClosestPoint> closest_point(const Vec3& point, double max_distance_m) const;

 private:
  double m_margin_m;
  std::vector<int> m_triangles;  ///< of the whole surface, ascending
  std::optional<TriangleBvh> m_tree;
};

}  // namespace musclebench

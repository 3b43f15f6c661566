#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/distance/triangle_distance.hpp"

namespace musclebench {

/// For each node of one surface the closest of those triangles of another that its own triangles intersect, whatever
/// the order in which they are met.
class MetTriangles {
 public:
  struct Closest {
    Vec3 point = Vec3::Zero();  ///< of the node, in the frame of the triangles
    ClosestOnTriangle found;
    int triangle = -1;
  };

  explicit MetTriangles(std::size_t nodes) : m_rounds(nodes, 0), m_closest(nodes) {}

  /// Forgets what was met.
  void start_round() {
    if (++m_round == 0) {  // the counter has come round: marks of 4 billion calls ago would count as new
      std::fill(m_rounds.begin(), m_rounds.end(), 0);
      m_round = 1;
    }
  }

  /// `point_of()` returns the position of the node; called once a round for each node.
  template <typename PointOf>
  void meet(int node, const PointOf& point_of, int triangle, const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto i = static_cast<std::size_t>(node);
    Closest& closest = m_closest[i];
    if (m_rounds[i] != m_round) {
      m_rounds[i] = m_round;
      closest = {point_of(), {}, -1};
      closest.found.squared_distance_m2 = std::numeric_limits<double>::infinity();
    }
    const ClosestOnTriangle found = closest_on_triangle(closest.point, a, b, c);
    // At equal distances the smallest index, so that the order does not matter.
    if (found.squared_distance_m2 < closest.found.squared_distance_m2 ||
        (found.squared_distance_m2 == closest.found.squared_distance_m2 && triangle < closest.triangle)) {
      closest.found = found;
      closest.triangle = triangle;
    }
  }

  /// Of a node that has met triangles in this round; else nullptr.
  [[nodiscard]] const Closest* find(int node) const {
    const auto i = static_cast<std::size_t>(node);
    return m_rounds[i] == m_round ? &m_closest[i] : nullptr;
  }

  [[nodiscard]] std::size_t bytes() const {
    return m_rounds.size() * sizeof(std::uint32_t) + m_closest.size() * sizeof(Closest);
  }

 private:
  std::vector<std::uint32_t> m_rounds;  ///< by node: the last round that met it
  std::vector<Closest> m_closest;       ///< by node, valid where its round is the current one
  std::uint32_t m_round = 0;
};

}  // namespace musclebench

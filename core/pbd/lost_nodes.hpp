#pragma once

#include <atomic>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include <climits>

#include "core/mesh/triangle_mesh.hpp"
#include "core/pbd/motion_limits.hpp"
#include "core/pbd/node_rows.hpp"

namespace musclebench {

/// Finds nodes that exceed the limits of motion. A quick test clears nearly every node. Only the others are measured.
/// Threads may call the const functions and measure different nodes at once.
class LostNodes {
 public:
  /// `start` has the initial positions of all nodes, m.
  explicit LostNodes(std::span<const Vec3> start);

  void set_limits(const MotionLimits& limits);
  [[nodiscard]] const MotionLimits& limits() const { return m_limits; }

  /// A quick test. True: the node is within its range. False: unknown, or the position is not a number.
  [[nodiscard]] bool is_near(const NodeRow& position) const { return sum_of_moduli(position - m_centre) <= m_near_m; }
  /// A quick test. True: the displacement is within its limit. False: unknown.
  [[nodiscard]] bool is_small(const NodeRow& move) const { return sum_of_moduli(move) <= m_limits.move_m; }

  /// The exact tests. A value that is not a number exceeds any limit.
  [[nodiscard]] bool is_out_of_range(int node, const Vec3& position) const;
  [[nodiscard]] bool is_too_far(const Vec3& move) const;

  /// Adds the node to the lost ones if its position or displacement exceeds a limit.
  void measure_position(int node, const Vec3& position) {
    if (is_out_of_range(node, position)) add(node);
  }
  void measure_move(int node, const Vec3& move) {
    if (is_too_far(move)) add(node);
  }

  /// The lost node with the smallest index since `clear`. It does not depend on the number of threads.
  [[nodiscard]] std::optional<int> first() const;
  [[nodiscard]] bool any() const { return m_first.load(std::memory_order_relaxed) != none; }
  void clear() { m_first = none; }

 private:
  static constexpr int none = INT_MAX;

  /// An upper bound of the length.
  static double sum_of_moduli(const NodeRow& vector) {
    return std::abs(vector.x) + std::abs(vector.y) + std::abs(vector.z);
  }
  void add(int node);

  std::vector<Vec3> m_start;  ///< by node
  MotionLimits m_limits;
  NodeRow m_centre;  ///< centre of the box around all initial positions
  double m_near_m;   ///< a position this close to the centre is within the range of every node
  std::atomic<int> m_first = none;
};

}  // namespace musclebench

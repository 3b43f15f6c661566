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

/// Finds the nodes that are beyond the limits of motion. Of every node and substep a quick comparison tells that it is
/// not; only where that fails are nodes measured.
class LostNodes {
 public:
  explicit LostNodes(std::span<const Vec3> start);

  void set_limits(const MotionLimits& limits);
  [[nodiscard]] const MotionLimits& limits() const { return m_limits; }

  /// Enough to tell that a node is within its range; false for what is no number.
  [[nodiscard]] bool is_near(const NodeRow& position) const { return sum_of_moduli(position - m_centre) <= m_near_m; }
  /// Enough to tell that a move is within its limit.
  [[nodiscard]] bool is_small(const NodeRow& move) const { return sum_of_moduli(move) <= m_limits.move_m; }

  [[nodiscard]] bool is_out_of_range(int node, const Vec3& position) const;
  [[nodiscard]] bool is_too_far(const Vec3& move) const;

  // Threads may measure at the same time, each nodes of its own.
  void measure_position(int node, const Vec3& position) {
    if (is_out_of_range(node, position)) add(node);
  }
  void measure_move(int node, const Vec3& move) {
    if (is_too_far(move)) add(node);
  }

  /// The first by its number of those that were found since `clear`: the same for any number of threads.
  [[nodiscard]] std::optional<int> first() const;
  [[nodiscard]] bool any() const { return m_first.load(std::memory_order_relaxed) != none; }
  void clear() { m_first = none; }

 private:
  static constexpr int none = INT_MAX;

  /// At least the length.
  static double sum_of_moduli(const NodeRow& vector) {
    return std::abs(vector.x) + std::abs(vector.y) + std::abs(vector.z);
  }
  void add(int node);

  std::vector<Vec3> m_start;  ///< by node
  MotionLimits m_limits;
  NodeRow m_centre;  ///< of the box around all starts
  double m_near_m;   ///< what is as near to it is within the range of every node
  std::atomic<int> m_first = none;
};

}  // namespace musclebench

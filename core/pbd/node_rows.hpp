#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"
#include "core/pbd/node_order.hpp"

namespace musclebench {

/// A node's position (world frame, m) with its inverse mass, or its velocity (m/s) with 0. Four doubles, so that SIMD
/// code can load rows and transpose them into lanes.
struct alignas(32) NodeRow {
  double x = 0, y = 0, z = 0;
  double inverse_mass = 0;  ///< 1/kg; 0 for a node that is attached to a bone

  [[nodiscard]] Vec3 position() const { return {x, y, z}; }
  void set_position(const Vec3& position) {
    x = position.x();
    y = position.y();
    z = position.z();
  }
};

/// The sum of all four components, one by one.
inline NodeRow operator+(const NodeRow& a, const NodeRow& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z, a.inverse_mass + b.inverse_mass};
}
/// The difference of all four components, one by one.
inline NodeRow operator-(const NodeRow& a, const NodeRow& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z, a.inverse_mass - b.inverse_mass};
}
/// All four components times `factor`.
inline NodeRow operator*(double factor, const NodeRow& a) {
  return {factor * a.x, factor * a.y, factor * a.z, factor * a.inverse_mass};
}

/// The rows of all nodes in the order of `NodeOrder`, followed by a padding row of inverse mass 0. SIMD lanes without a
/// constraint use the padding row. Threads may write different rows at once.
class NodeRows {
 public:
  NodeRows() = default;
  /// `positions` (m) and `inverse_masses` (1/kg) are by node.
  NodeRows(const NodeOrder& order, std::span<const Vec3> positions, std::span<const double> inverse_masses)
      : m_rows(order.size() + 1) {
    for (std::size_t row = 0; row < order.size(); ++row) {
      const auto node = static_cast<std::size_t>(order.node_in(row));
      m_rows[row].set_position(positions[node]);
      m_rows[row].inverse_mass = inverse_masses[node];
    }
  }

  /// Number of nodes, without the padding row.
  [[nodiscard]] std::size_t size() const { return m_rows.size() - 1; }
  NodeRow& operator[](std::size_t row) { return m_rows[row]; }
  const NodeRow& operator[](std::size_t row) const { return m_rows[row]; }
  [[nodiscard]] NodeRow* data() { return m_rows.data(); }
  [[nodiscard]] const NodeRow* data() const { return m_rows.data(); }

  /// Where constraints add up what they do from now on, by row, padding included: mass times correction, kg m. Of a
  /// node that a bone carries, too, which is not moved: its bone bears them. Null: nobody asks.
  void set_impulses(NodeRow* impulses) { m_impulses = impulses; }
  [[nodiscard]] NodeRow* impulses() { return m_impulses; }

 private:
  std::vector<NodeRow> m_rows = std::vector<NodeRow>(1);
  NodeRow* m_impulses = nullptr;
};

}  // namespace musclebench

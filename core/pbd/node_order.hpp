#pragma once

#include <span>
#include <vector>

#include "core/mesh/body.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The row (`NodeRows`) of each node: body by body, along the longest side of the box around it. Neighbours are then
/// near each other in memory, however the mesh numbers them, and ranges of consecutive rows share few constraints.
class NodeOrder {
 public:
  NodeOrder() = default;
  /// `bodies` are in the order of their nodes and have all of them.
  NodeOrder(std::span<const Vec3> positions, std::span<const Body> bodies);

  [[nodiscard]] std::size_t size() const { return m_rows.size(); }
  [[nodiscard]] int row_of(int node) const { return m_rows[static_cast<std::size_t>(node)]; }
  [[nodiscard]] int node_in(std::size_t row) const { return m_nodes[row]; }

 private:
  std::vector<int> m_rows;   ///< by node
  std::vector<int> m_nodes;  ///< by row
};

}  // namespace musclebench

#pragma once

#include <span>
#include <vector>

#include "core/mesh/body.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Maps each node to its row in `NodeRows`. Rows are sorted by body, and then along the longest side of the body's box.
/// Neighbours are then close in memory for any numbering of the mesh, and ranges of rows share few constraints. Queries
/// are safe from several threads.
class NodeOrder {
 public:
  NodeOrder() = default;
  /// `positions` are those of all nodes, in metres. `bodies` must be in the order of their nodes and contain all of
  /// them.
  NodeOrder(std::span<const Vec3> positions, std::span<const Body> bodies);

  [[nodiscard]] std::size_t size() const { return m_rows.size(); }
  [[nodiscard]] int row_of(int node) const { return m_rows[static_cast<std::size_t>(node)]; }
  [[nodiscard]] int node_in(std::size_t row) const { return m_nodes[row]; }

 private:
  std::vector<int> m_rows;   ///< by node
  std::vector<int> m_nodes;  ///< by row
};

}  // namespace musclebench

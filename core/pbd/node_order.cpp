#include "core/pbd/node_order.hpp"

#include <algorithm>
#include <numeric>

#include <Eigen/Geometry>

namespace musclebench {

NodeOrder::NodeOrder(std::span<const Vec3> positions) : m_rows(positions.size()), m_nodes(positions.size()) {
  Eigen::AlignedBox3d box;
  for (const Vec3& position : positions) {
    box.extend(position);
  }
  int longest = 0;
  if (!positions.empty()) box.sizes().maxCoeff(&longest);
  std::iota(m_nodes.begin(), m_nodes.end(), 0);
  std::ranges::stable_sort(m_nodes, {}, [&](int node) { return positions[static_cast<std::size_t>(node)][longest]; });
  for (std::size_t row = 0; row < m_nodes.size(); ++row) {
    m_rows[static_cast<std::size_t>(m_nodes[row])] = static_cast<int>(row);
  }
}

}  // namespace musclebench

#include "core/pbd/node_order.hpp"

#include <algorithm>
#include <numeric>

#include <Eigen/Geometry>

namespace musclebench {

namespace {

int longest_side(std::span<const Vec3> positions) {
  Eigen::AlignedBox3d box;
  for (const Vec3& position : positions) {
    box.extend(position);
  }
  int longest = 0;
  if (!positions.empty()) box.sizes().maxCoeff(&longest);
  return longest;
}

}  // namespace

NodeOrder::NodeOrder(std::span<const Vec3> positions, std::span<const Body> bodies)
    : m_rows(positions.size()), m_nodes(positions.size()) {
  std::iota(m_nodes.begin(), m_nodes.end(), 0);
  for (const Body& body : bodies) {
    const auto first = static_cast<std::size_t>(body.first_node);
    const auto count = static_cast<std::size_t>(body.last_node) - first;
    const int axis = longest_side(positions.subspan(first, count));
    std::ranges::stable_sort(std::span(m_nodes).subspan(first, count), {},
                             [&](int node) { return positions[static_cast<std::size_t>(node)][axis]; });
  }
  for (std::size_t row = 0; row < m_nodes.size(); ++row) {
    m_rows[static_cast<std::size_t>(m_nodes[row])] = static_cast<int>(row);
  }
}

}  // namespace musclebench

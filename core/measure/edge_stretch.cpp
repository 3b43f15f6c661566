#include "core/measure/edge_stretch.hpp"

#include <algorithm>

#include "core/base/percentile.hpp"
#include "core/mesh/mesh_edges.hpp"

namespace musclebench {

EdgeStretchMeter::EdgeStretchMeter(const TriangleMesh& rest) {
  const MeshEdges edges(rest);
  for (int i = 0; i < edges.count(); ++i) {
    const EdgeUse& use = edges.uses(i).front();
    const double length_m =
        (rest.vertices[static_cast<std::size_t>(use.high)] - rest.vertices[static_cast<std::size_t>(use.low)]).norm();
    if (!(length_m > 0)) continue;
    m_edges.push_back({use.low, use.high, length_m});
    m_mean_length_m += length_m;
  }
  if (!m_edges.empty()) m_mean_length_m /= static_cast<double>(m_edges.size());
  m_stretches.resize(m_edges.size());
}

EdgeStretch EdgeStretchMeter::measure(std::span<const Vec3> positions) {
  if (m_edges.empty()) return {};
  for (std::size_t i = 0; i < m_edges.size(); ++i) {
    const auto& [from, to, rest_length_m] = m_edges[i];
    const Vec3 edge = positions[static_cast<std::size_t>(to)] - positions[static_cast<std::size_t>(from)];
    m_stretches[i] = edge.norm() / rest_length_m;
  }
  const auto p99 = m_stretches.begin() + static_cast<std::ptrdiff_t>(percentile_index(m_stretches.size(), 0.99));
  std::nth_element(m_stretches.begin(), p99, m_stretches.end());
  return {*std::max_element(p99, m_stretches.end()), *p99};
}

}  // namespace musclebench

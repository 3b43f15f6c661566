#include "core/pbd/lost_nodes.hpp"

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

LostNodes::LostNodes(std::span<const Vec3> start) : m_start(start.begin(), start.end()) {
  if (!m_start.empty()) m_centre.set_position(bounding_box(m_start).center());
  set_limits({});
}

void LostNodes::set_limits(const MotionLimits& limits) {
  m_limits = limits;
  const double spread_m = m_start.empty() ? 0 : bounding_box(m_start).diagonal().norm();
  m_near_m = limits.range_m - 0.5 * spread_m;
}

// A position that is no number is lost.

bool LostNodes::is_out_of_range(int node, const Vec3& position) const {
  return !((position - m_start[static_cast<std::size_t>(node)]).norm() <= m_limits.range_m);
}

bool LostNodes::is_too_far(const Vec3& move) const { return !(move.norm() <= m_limits.move_m); }

std::optional<int> LostNodes::first() const {
  const int node = m_first;
  return node == none ? std::nullopt : std::optional(node);
}

void LostNodes::add(int node) {
  int first = m_first;
  while (node < first && !m_first.compare_exchange_weak(first, node)) {
  }
}

}  // namespace musclebench

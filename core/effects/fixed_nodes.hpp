#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Nodes that bones carry: of inverse mass 0, so that no constraint moves them. One all of whose nodes are such changes
/// nothing, whatever it computes, and is left out; the others keep their order and with it every bit.
class FixedNodes {
 public:
  explicit FixedNodes(const EffectInput& input) : m_is_fixed(input.mesh.vertices.size(), 0) {
    for (const BoundNode& bound : input.bound_nodes) m_is_fixed[static_cast<std::size_t>(bound.node)] = 1;
  }

  template <typename Indices>
  [[nodiscard]] bool are_all(const Indices& nodes) const {
    return std::ranges::all_of(nodes, [&](int node) { return m_is_fixed[static_cast<std::size_t>(node)] != 0; });
  }

 private:
  std::vector<char> m_is_fixed;
};

}  // namespace musclebench

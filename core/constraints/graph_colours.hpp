#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace musclebench {

/// The order of constraints by graph colour, and within a colour as given: no two of a colour share a node, so that
/// successive Gauss-Seidel steps do not depend on each other's result. A node of -1 is none.
///
/// Greedy: each takes the smallest colour that none of its nodes has yet. 64 colours are enough for up to about 20
/// triangles a vertex; constraints beyond share the last colour, which only costs speed.
template <std::size_t Nodes>
std::vector<int> order_by_colour(std::span<const std::array<int, Nodes>> constraints, std::size_t nodes) {
  constexpr int last_colour = 63;
  std::vector<std::uint64_t> seen(nodes, 0);
  std::vector<int> colours;
  colours.reserve(constraints.size());
  for (const std::array<int, Nodes>& corners : constraints) {
    std::uint64_t taken = 0;
    for (const int corner : corners) {
      taken |= corner >= 0 ? seen[static_cast<std::size_t>(corner)] : 0;
    }
    int colour = 0;
    while (colour < last_colour && ((taken >> colour) & 1U) != 0) {
      ++colour;
    }
    for (const int corner : corners) {
      if (corner >= 0) seen[static_cast<std::size_t>(corner)] |= std::uint64_t{1} << colour;
    }
    colours.push_back(colour);
  }
  std::vector<int> order(constraints.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](int i) { return colours[static_cast<std::size_t>(i)]; });
  return order;
}

}  // namespace musclebench

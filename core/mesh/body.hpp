#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// One of several muscles that share a mesh: a range of nodes and a range of triangles of that mesh.
struct Body {
  std::string name;
  int first_node = 0;
  int last_node = 0;  ///< one past the last
  std::size_t first_triangle = 0;
  std::size_t last_triangle = 0;  ///< one past the last
  double activation = 1;          ///< 0 to 1: its share of the activation that the scene's effects give

  [[nodiscard]] bool has_node(int node) const { return node >= first_node && node < last_node; }
};

/// The index of the body that contains the node. `bodies` must be in the order of their nodes and contain every node.
inline std::size_t body_of(std::span<const Body> bodies, int node) {
  return static_cast<std::size_t>(std::ranges::upper_bound(bodies, node, {}, &Body::last_node) - bodies.begin());
}

/// The volume of a body in m3, by the divergence theorem. `positions` and `triangles` are those of the whole mesh. The
/// volume is negative if the surface is wound inwards. The surface must be closed.
double body_volume_m3(std::span<const Vec3> positions, std::span<const Triangle> triangles, const Body& body);

}  // namespace musclebench

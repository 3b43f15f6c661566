#pragma once

#include <vector>

#include "core/scene/scene.hpp"

namespace musclebench {

/// Nodes that lie inside a surface before anything moves.
struct RestOverlap {
  int nodes = 0;
  int of_nodes = 0;  ///< how many were looked at
  double deepest_m = 0;
};

/// Of each bone the overlap with the nodes that no attachment binds, which contacts push out.
std::vector<RestOverlap> free_overlaps_at_rest(const Scene& scene);

/// Of each bone the overlap with the nodes that attachments bind, to whatever bone; those stay where they are.
std::vector<RestOverlap> attached_overlaps_at_rest(const Scene& scene);

/// Of each of the scene's muscle pairs, the nodes of either in the other.
std::vector<RestOverlap> muscle_overlaps_at_rest(const Scene& scene);

}  // namespace musclebench

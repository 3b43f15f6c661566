#pragma once

#include <vector>

#include "core/scene/scene.hpp"

namespace musclebench {

/// The nodes of the muscle that lie inside one bone before anything moves.
struct RestOverlap {
  int nodes = 0;
  double deepest_m = 0;
};

/// Of each bone the overlap with the nodes that no attachment binds.
std::vector<RestOverlap> free_overlaps_at_rest(const Scene& scene);

}  // namespace musclebench

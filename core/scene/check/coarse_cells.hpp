#pragma once

#include <cstddef>
#include <vector>

#include "core/scene/check/scene_check.hpp"

namespace musclebench {

/// A bone whose cells make distances wrong by more than some nodes are away from it.
struct CoarseCells {
  std::size_t bone = 0;
  double nodes_share = 0;  ///< of the free nodes: those nearer at rest than the error
  double rest_gap_m = 0;   ///< of the nearest node
};

/// Of the backends that the check was told of.
std::vector<CoarseCells> coarse_cells(CheckContext& context);

}  // namespace musclebench

#pragma once

#include <span>
#include <vector>

#include "core/geometry/triangle_mesh.hpp"

namespace musclebench {

/// An order of `nodes` in which those that follow each other are close together: along a curve that fills space
/// (Morton's), or as they are where that way is shorter. Places in `nodes`; `positions` are of all nodes, and may be
/// anything, also not finite.
std::vector<int> coherent_order(std::span<const Vec3> positions, std::span<const int> nodes);

}  // namespace musclebench

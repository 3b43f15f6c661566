#pragma once

#include <string>
#include <string_view>

#include "core/pbd/simulation.hpp"

namespace musclebench {

/// Where and how a node was lost in `frame`, which `simulation` has just stepped, in words; empty when all is well.
std::string describe_divergence(const Simulation& simulation, int frame);

/// What moved the node lost in `frame` beyond the limits: steps `simulation`, which is at its start, there again. Empty
/// where none is lost in that frame, or where it is stopped before. `observe_last` sees the collision steps of the up
/// to `kept_frames` frames before it.
std::string cause_of_divergence(Simulation& simulation, int frame, CollisionObserver& observe_last);
inline constexpr int frames_kept_before_divergence = 3;

}  // namespace musclebench

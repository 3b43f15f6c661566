#pragma once

#include <memory>

#include "backends/fcl/fcl_options.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// Surface against surface, as the paper uses FCL. One bounding-volume tree a bone, the bones in a broad-phase manager,
/// one tree of the muscle's surface; every `update` moves the bones and deforms the muscle's tree; `detect` collects
/// all pairs of triangles that FCL finds intersecting and makes of them one contact a node and bone (see NodeContacts).
///
/// Surfaces that intersect say nothing of what lies behind them: a node is found only where one of its triangles cuts
/// the bone's surface, so nodes deep inside are missed, and the depth is the distance to the closest bone triangle that
/// its own triangles cut. That is the method, and is left for the harness to measure.
///
/// `build` throws InputError for a muscle without a triangle of positive area.
std::unique_ptr<CollisionBackend> make_surface_backend(const FclOptions& options);

}  // namespace musclebench

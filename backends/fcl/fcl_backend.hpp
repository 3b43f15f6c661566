#pragma once

#include <memory>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// The backend `fcl`: surface against surface with the Flexible Collision Library 0.7, as the paper uses it. One
/// bounding-volume tree a bone in one broad-phase manager, one tree of the muscle's surface in another; every `update`
/// moves the bones, deforms the muscle's tree and updates both managers; `detect` collects all intersecting pairs of
/// triangles and makes of them one contact a node and bone (see NodeContacts).
///
/// Surfaces that intersect say nothing of what lies behind them: a node is found only where one of its triangles cuts
/// the bone's surface, so nodes deep inside are missed, and the depth is the distance to the closest bone triangle that
/// its own triangles cut. That is the method, and is left for the harness to measure.
std::vector<ParameterSpec> fcl_parameters();

/// `parameters` as `fcl_parameters` describes them. Throws InputError for a combination that FCL answers wrongly.
/// `build` throws InputError for a muscle without a triangle of positive area.
std::unique_ptr<CollisionBackend> make_fcl_backend(const Parameters& parameters);

}  // namespace musclebench

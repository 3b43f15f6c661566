#pragma once

#include <memory>

#include "backends/fcl/fcl_options.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// Each node by itself against each bone's tree: what FCL can do where nodes are what matters. The muscle's surface is
/// not used. FCL takes a bone's surface for hollow: it tells how far a triangle is, never on which side. The side comes
/// from the pseudo-normal of the triangle that FCL names, so it may be wrong where the surface is not clean.
///
/// - `Query::node_distance` asks for the distance of a point (a sphere of radius 0: where a larger one overlaps a
///   triangle, FCL 0.7 leaves the distance unset).
/// - `Query::node_collide` asks which triangles a sphere of `node_radius_m` meets and takes the closest of them. A node
///   farther from the surface than that, on either side, meets none.
///
/// Nodes are asked in the bone's rest frame: moved models without orientation would be rebuilt in every query. What FCL
/// finds is measured again here (see NodeSurface).
std::unique_ptr<CollisionBackend> make_node_backend(const FclOptions& options);

}  // namespace musclebench

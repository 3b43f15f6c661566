#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/effects/effect_registry.hpp"
#include "core/mesh/retinaculum.hpp"

namespace musclebench {

/// Where a point is to a ring.
struct PlaceInRing {
  double along_m = 0;            ///< from its plane, along its axis
  double outwards_m = 0;         ///< from its axis
  Vec3 outwards = Vec3::Zero();  ///< unit vector; zero on the axis
};

PlaceInRing place_in_ring(const Retinaculum& ring, const Vec3& point_m);

/// Where an edge passes the ring's plane; nothing: both ends are on one side.
std::optional<PlaceInRing> crossing_of(const Retinaculum& ring, const Vec3& from, const Vec3& to);

/// The ends of edges of `body` that pass the plane of the ring within two radii of its axis, and the nodes that are at
/// most `slide_m` from them along edges, ascending. Empty: no edge passes. `mesh`: of all muscles, at rest.
std::vector<int> nodes_through_ring(const TriangleMesh& mesh, const Body& body, const Retinaculum& ring,
                                    double slide_m);

/// The middle of a tendon stays within the clearance of the axis of its ring. The middle is the mean of the nodes that
/// are nearer than w = half_width_m to the ring's plane, each by its area at rest and by 1 - |z| / w. A correction
/// moves nodes by the same weight, so that it does not flatten the tendon. A hard one-sided constraint without
/// friction; the bone bears the push.
std::unique_ptr<Effect> make_retinaculum(const EffectInput& input, const Parameters& parameters);
std::vector<ParameterSpec> retinaculum_parameters();

}  // namespace musclebench

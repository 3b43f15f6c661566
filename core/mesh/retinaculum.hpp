#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/body.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A band of tissue that holds a tendon to a bone: a ring that moves with the bone, and through which the tendon
/// slides. Lengths in metres, in the rest frame of the bone.
struct Retinaculum {
  std::string name;
  int bone = 0;            ///< index of the bone
  std::size_t muscle = 0;  ///< index of the muscle whose tendon it holds
  Vec3 centre_m = Vec3::Zero();
  Vec3 axis = Vec3::UnitX();    ///< unit vector along the tendon
  double radius_m = 0;          ///< > 0
  double half_width_m = 0;      ///< > 0: it acts on nodes nearer than that to its plane, the more, the nearer
  double clearance_m = 0;       ///< how far the middle of the tendon may be from the axis: the radius less the tendon's
  std::vector<int> nodes = {};  ///< of the tendon: those that may slide through it, ascending
  std::string location = {};    ///< file and line, for messages
};

/// Where a point is to a ring.
struct PlaceInRing {
  double along_m = 0;            ///< from its plane, along its axis
  double outwards_m = 0;         ///< from its axis
  Vec3 outwards = Vec3::Zero();  ///< unit vector; zero on the axis
};

/// Of a point in the rest frame of the bone, m.
PlaceInRing place_in_ring(const Retinaculum& ring, const Vec3& point_m);

/// Where an edge passes the ring's plane; nothing: both ends are on one side.
std::optional<PlaceInRing> crossing_of(const Retinaculum& ring, const Vec3& from, const Vec3& to);

/// The ends of edges of `body` that pass the plane of the ring within two radii of its axis, and the nodes that are at
/// most `slide_m` from them along edges, ascending. Empty: no edge passes. `mesh`: of all muscles, at rest.
std::vector<int> nodes_through_ring(const TriangleMesh& mesh, const Body& body, const Retinaculum& ring,
                                    double slide_m);

}  // namespace musclebench

#pragma once

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A muscle node that was found inside a bone. There is at most one contact for each node and bone.
///
/// To move the node to the surface, add depth_m * normal to its position. A backend without `Capabilities::depth`
/// leaves depth and normal at zero.
struct Contact {
  int node = 0;                ///< index of a muscle vertex
  int bone = 0;                ///< index of a bone
  double depth_m = 0;          ///< distance from the node to the bone's surface, >= 0
  Vec3 normal = Vec3::Zero();  ///< unit vector in the world frame that points out of the bone
};

}  // namespace musclebench

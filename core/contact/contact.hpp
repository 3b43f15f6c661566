#pragma once

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// One node of the muscle found inside one bone. There is at most one contact a node and bone.
struct Contact {
  int node = 0;
  int bone = 0;
  double depth_m = 0;  ///< distance to the surface, >= 0; 0 when the backend cannot tell (`Capabilities::depth`)
  Vec3 normal = Vec3::Zero();  ///< unit, world frame, points out of the bone; zero when the backend cannot tell
};

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <string>
#include <vector>

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

}  // namespace musclebench

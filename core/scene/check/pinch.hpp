#pragma once

#include "core/scene/check/bone_nearness.hpp"

namespace musclebench {

/// Two bones between which a muscle's nodes have less room than the muscle is thick.
struct Pinch {
  std::size_t first_bone = 0;
  std::size_t second_bone = 0;
  int nodes = 0;           ///< of the sample, each counted once
  double room_m = 0;       ///< smallest sum of a node's distances to both
  double thickness_m = 0;  ///< of the muscle at that node
  int node = 0;
};

/// Of each pair of bones with such nodes: outside of both at a pose, between them (the normals towards it are opposed),
/// on a side of the muscle that looks towards one of them.
std::vector<Pinch> pinches(const PoseEstimates& poses, const std::vector<BoneNearness>& nearness,
                           const std::vector<double>& thickness_m);

}  // namespace musclebench

#pragma once

#include "core/scene/check/bone_nearness.hpp"

namespace musclebench {

/// How deep a bone can cut faces of a muscle whose corners are all outside of it.
struct RidgeDepth {
  std::size_t muscle = 0;
  int samples = 0;       ///< points of the bone that a node of the muscle is near at some pose
  double p99_m = 0;      ///< of the depth at these points
  double largest_m = 0;  ///< the same
  double edge_m = 0;     ///< of the muscle where the depth is largest: mean length of the node's edges at that pose
  Vec3 point = Vec3::Zero();  ///< where that is, in the bone's rest frame
};

/// Estimated depth at a point of a bone's surface: an edge of length `edge_m` lies over the point with both ends on the
/// bone, in the direction in which that is deepest. It is the sagitta of the surface over the edge: edge^2 / (8 radius)
/// where the bone is round, up to half the edge at a blade.
double cut_depth_m(const TriangleBvh& bone, const Vec3& point, const Vec3& normal, double edge_m);

/// Of each muscle that comes near the bone. Edges are as long as the poses stretch them.
std::vector<RidgeDepth> ridge_depths(const Scene& scene, std::size_t bone, const PoseEstimates& poses,
                                     const BoneNearness& nearness);

}  // namespace musclebench

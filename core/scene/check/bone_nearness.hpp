#pragma once

#include <vector>

#include "core/scene/check/pose_estimates.hpp"

namespace musclebench {

/// A free node near a bone at one of the estimated poses.
struct NearNode {
  int node = 0;
  std::size_t pose = 0;
  Vec3 point = Vec3::Zero();          ///< of the bone's surface, closest to the node; in the bone's rest frame
  Vec3 normal = Vec3::UnitZ();        ///< unit, out of the bone there
  Vec3 muscle_normal = Vec3::Zero();  ///< unit, out of the muscle at the node, in that frame; 0 without triangles
  double signed_distance_m = 0;       ///< negative inside
};

/// How near the free nodes come to one bone.
struct BoneNearness {
  /// At rest, of all free nodes that are outside: the smallest distance; infinite where there are none.
  double rest_gap_m = 0;
  std::vector<double> rest_distances_m;  ///< by free node, signed; those far away are left out
  /// Of a sample of nodes, over all poses: the smallest distance, negative inside.
  double least_distance_m = 0;
  std::vector<NearNode> near;  ///< of the sample: inside, or no farther than the muscle is thick at the node
};

/// By bone. `thickness_m`: of the muscle at each node, how far from its bone a node counts as near.
std::vector<BoneNearness> bone_nearness(const Scene& scene, const PoseEstimates& poses,
                                        const std::vector<double>& thickness_m);

/// By node: the mean length of its edges at rest; 0 for a node without.
std::vector<double> node_edge_lengths_m(const TriangleMesh& mesh);

/// By node: the sum of its triangles' normals times their areas, made a unit vector; 0 for a node without.
std::vector<Vec3> node_normals(const TriangleMesh& mesh);

/// By node: how thick its muscle is there, from the node inwards to where its surface is left again; 0 where that can't
/// be told.
std::vector<double> node_thicknesses_m(const Scene& scene);

}  // namespace musclebench

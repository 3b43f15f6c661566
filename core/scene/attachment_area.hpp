#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/bvh/triangle_bvh.hpp"

namespace musclebench {

/// An area on a bone, outlined by points on it, and how near a node has to be to be bound to it.
struct AttachmentArea {
  std::vector<Vec3> outline_m;  ///< at least 3 points, any order; the area is their convex hull in their mean plane
  double distance_m = 0;        ///< from the node to the bone
  double margin_m = 0;          ///< by which the area is grown on all sides
};

/// The nodes (ascending) within `distance_m` of the bone whose closest point on it lies over the area. Everything in
/// one frame. Points on the far side of the bone do not count: the closest point must be nearer to the mean plane than
/// the outline is wide.
std::vector<int> nodes_over_area(std::span<const Vec3> nodes, const TriangleMesh& bone, const AttachmentArea& area);

/// How far a node is from being bound.
struct DistanceToArea {
  double to_bone_m = 0;
  double beside_area_m = 0;  ///< from its closest point on the bone to the outlined area; 0 over it
};

/// Of the node that the least enlargement of `distance_m` and `margin_m` would bind; nothing where no node lies on the
/// area's side of the bone.
std::optional<DistanceToArea> nearest_to_area(std::span<const Vec3> nodes, const TriangleBvh& bone,
                                              const AttachmentArea& area);

}  // namespace musclebench

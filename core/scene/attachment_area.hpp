#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/bvh/triangle_bvh.hpp"

namespace musclebench {

/// What a node has to be near.
enum class AttachmentSurface {
  bone,     ///< the bone's surface, over the area
  outline,  ///< the area itself: where what it lies on (a vertebra, a tendon) has no mesh, and a bone carries it
};

/// An area on a bone, outlined by points on it, and how near a node has to be to be bound to it.
struct AttachmentArea {
  std::vector<Vec3> outline_m;  ///< at least 3 points, any order; the area is their convex hull in their mean plane
  double distance_m = 0;        ///< from the node to the surface
  double margin_m = 0;          ///< by which the area is grown on all sides
  AttachmentSurface surface = AttachmentSurface::bone;
  bool is_placed = false;  ///< the outline is of a file, and was moved with the bone's mesh
};

/// The nodes (ascending) within `distance_m` of the surface whose closest point on it lies over the area. Everything in
/// one frame. Points on the far side of a bone do not count: the closest point must be nearer to the mean plane than
/// the outline is wide. Of an outline the distance is that from its mean plane, to either side.
std::vector<int> nodes_over_area(std::span<const Vec3> nodes, const TriangleMesh& bone, const AttachmentArea& area);

/// How far a node is from being bound.
struct DistanceToArea {
  double to_surface_m = 0;
  double beside_area_m = 0;  ///< from its closest point on the surface to the outlined area; 0 over it
};

/// Of the node that the least enlargement of `distance_m` and `margin_m` would bind; nothing where no node lies on the
/// area's side of the bone.
std::optional<DistanceToArea> nearest_to_area(std::span<const Vec3> nodes, const TriangleBvh& bone,
                                              const AttachmentArea& area);

}  // namespace musclebench

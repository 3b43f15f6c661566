#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/bvh/triangle_bvh.hpp"

namespace musclebench {

/// The surface that a node must be close to.
enum class AttachmentSurface {
  bone,     ///< the bone's surface over the area
  outline,  ///< the area itself: for an attachment to a part without a mesh (a vertebra, a tendon) that moves with a
            ///< bone
  points,   ///< each point by itself, not the area between them: places that were picked or painted on the muscle
};

/// An area on a bone to which muscle nodes are attached.
struct AttachmentArea {
  std::vector<Vec3> outline_m;  ///< at least 3 points in any order; the area is their convex hull in their mean plane,
                                ///< but of `points`, which has no area and no margin, and may have fewer
  double distance_m = 0;        ///< largest distance of an attached node from the surface
  double margin_m = 0;          ///< the area is enlarged by this on all sides
  AttachmentSurface surface = AttachmentSurface::bone;
  bool is_placed = false;  ///< the outline is of a file, and was moved with the bone's mesh
};

/// The indices of nodes that are attached, ascending. A node is attached if it is within `distance_m` of the surface
/// and its closest point is over the area. All positions are in one frame, in metres.
///
/// Points on the far side of a bone do not count: the closest point must be nearer to the mean plane than the outline
/// is wide. For `outline` the distance is that from the mean plane, on either side; for `points` it is that from the
/// nearest of them.
std::vector<int> nodes_over_area(std::span<const Vec3> nodes, const TriangleMesh& bone, const AttachmentArea& area);

/// The distance of a node from an attachment area.
struct DistanceToArea {
  double to_surface_m = 0;
  double beside_area_m = 0;  ///< from the node's closest point on the surface to the area; 0 over the area
};

/// The distance of the node that would be attached first if `distance_m` and `margin_m` were increased. Returns nothing
/// if no node is on the area's side of the bone.
std::optional<DistanceToArea> nearest_to_area(std::span<const Vec3> nodes, const TriangleBvh& bone,
                                              const AttachmentArea& area);

}  // namespace musclebench

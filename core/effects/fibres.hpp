#pragma once

#include <vector>

#include "core/geometry/triangle_mesh.hpp"

namespace musclebench {

/// A straight piece of a muscle fibre in the muscle's rest pose, m.
struct FibreSegment {
  Vec3 start = Vec3::Zero();
  Vec3 end = Vec3::Zero();
};

/// |cos| of the angle between `direction` and the fibre segment closest to `point`; 0 without fibres, for a direction
/// or a fibre of no length.
double alignment_with_nearest_fibre(const std::vector<FibreSegment>& fibres, const Vec3& point, const Vec3& direction);

/// Straight fibres from an origin area to an insertion area: `count` lines that join the areas' nodes in the order of
/// their places along each area's longest direction. Empty when an area has no nodes.
std::vector<FibreSegment> fibres_between(const std::vector<Vec3>& origin, const std::vector<Vec3>& insertion,
                                         int count);

}  // namespace musclebench

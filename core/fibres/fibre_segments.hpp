#pragma once

#include <algorithm>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A straight segment of a muscle fibre in the muscle's rest pose, in metres.
struct FibreSegment {
  Vec3 start = Vec3::Zero();
  Vec3 end = Vec3::Zero();
};

/// Inline: each edge of a muscle asks for its distance to each segment.
inline double squared_distance(const FibreSegment& segment, const Vec3& point) {
  const Vec3 along = segment.end - segment.start;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp((point - segment.start).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (segment.start + t * along - point).squaredNorm();
}

/// Fibres along the surface from an origin area to an insertion area: the direction field is the gradient of the
/// harmonic function that is 0 on `origin` and 1 on `insertion` (Choi and Blemker 2013 reconstruct fascicles from such
/// a field), here solved on the surface with cotangent weights. One segment a triangle, evenly thinned to at most
/// `most_segments`; triangles on which the function is constant (inside the areas) have none. Empty when an area has no
/// nodes or the surface does not connect them.
std::vector<FibreSegment> fibres_between(const TriangleMesh& muscle, const std::vector<int>& origin,
                                         const std::vector<int>& insertion, int most_segments);

}  // namespace musclebench

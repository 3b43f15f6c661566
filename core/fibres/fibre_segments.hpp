#pragma once

#include <algorithm>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A straight segment of a muscle fibre in the rest pose of the muscle, in metres.
struct FibreSegment {
  Vec3 start = Vec3::Zero();
  Vec3 end = Vec3::Zero();
};

/// The squared distance from a point to a segment, in m2. Inline, because each edge of a muscle asks for each segment.
inline double squared_distance(const FibreSegment& segment, const Vec3& point) {
  const Vec3 along = segment.end - segment.start;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp((point - segment.start).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (segment.start + t * along - point).squaredNorm();
}

/// Computes fibres along a muscle's surface from an origin area to an insertion area. Both are lists of node indices.
///
/// The fibres follow the gradient of the harmonic function that is 0 on `origin` and 1 on `insertion`. Choi and Blemker
/// 2013 reconstruct fascicles from such a field. Here it is solved on the surface with cotangent weights. Each triangle
/// gives one segment, except where the function is constant, inside the areas. The segments are thinned evenly to at
/// most `most_segments`. The result is empty if an area has no nodes, or if the surface does not connect the areas.
std::vector<FibreSegment> fibres_between(const TriangleMesh& muscle, const std::vector<int>& origin,
                                         const std::vector<int>& insertion, int most_segments);

}  // namespace musclebench

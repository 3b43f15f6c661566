#pragma once

#include <span>
#include <vector>

#include "core/measure/crossings.hpp"
#include "core/referee/muscle_referee.hpp"

namespace musclebench {

/// The deepest point of a muscle's surface in another.
struct DeepestInMuscle {
  double depth_m = 0;  ///< 0: no point inside was found
  double bound_m = 0;  ///< no point of the triangles is deeper; exceeds the depth by the tolerance where that sufficed
  bool complete = true;
  int triangle = -1;
  int other = -1;
};

/// Finds how deep the triangles are in the muscles, as `referee` has last judged them: edges and faces, not nodes only.
///
/// Branch and bound, best first: a point's depth differs from that of the triangle's centre by no more than their
/// distance. The answer is the depth of a point, and too small by at most `tolerance_m`, unless more than `queries`
/// distances would be asked for.
DeepestInMuscle deepest_in_muscles(const MuscleReferee& referee, std::span<const Triangle> triangles,
                                   std::span<const Vec3> positions, std::span<const TriangleInMuscle> candidates,
                                   double tolerance_m, long queries);

/// Triangles that pass through another muscle, and those of which a node is inside one: no other point of a surface is
/// inside. `crossing`: of the last CrossingMeter::count; `inside`: nodes and muscles, of the last MuscleReferee::judge.
std::vector<TriangleInMuscle> triangles_in_muscles(std::span<const Triangle> triangles,
                                                   std::span<const TriangleInMuscle> crossing,
                                                   std::span<const Contact> inside);

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "core/recording/frame_source.hpp"
#include "core/scene/scene.hpp"
#include "datasets/queries/query_set.hpp"

namespace musclebench {

/// Which points of a recording a query set gets, and how many others.
struct QueryChoice {
  int moments = 8;            ///< evenly over the motion
  int steps = 3;              ///< successive ones at each moment, no more than a frame has
  double band_m = 0.01;       ///< points no farther than this from the surface
  int around = 2000;          ///< hard points about each bone beside those of the motion, see points_about
  std::size_t most = 50'000;  ///< of more, every so many-th node is kept, so that each node's queries stay together
};

/// The queries with the Referee's answers; `about` is left empty. `report` gets the number of moments done. Throws
/// InputError where the motion brings no node that near to a bone.
QuerySet queries_of(const Scene& scene, FrameSource& recording, const QueryChoice& choice,
                    const std::function<void(int)>& report);

/// The Referee's answers about points (rest frame, m) and one bone.
QuerySet queries_about(const Bone& bone, std::span<const Vec3> points);

}  // namespace musclebench

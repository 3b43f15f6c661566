#pragma once

#include <optional>
#include <vector>

#include "bench/hard/moved_scene.hpp"

namespace musclebench {

/// Of one flexion there and back and the rest after it, in which the muscle comes to rest.
struct CourseFrames {
  int moving;
  int resting;

  [[nodiscard]] constexpr int all() const { return moving + resting; }
};

/// The motion of each bone so many times one after the other, each with its rest.
void repeat_motions(Scene& scene, const CourseFrames& frames, int times);

/// Root of the mean square of the nodes' distances between two shapes, m.
double rms_gap_m(const std::vector<Vec3>& from, const std::vector<Vec3>& to);

/// A cell that would take too long by what one substep at rest takes: in the short run, which ends within two minutes
/// for all backends, 4 s; in the long one 15 min, so that a cell of four muscles ends before it counts as hung. Where
/// the muscle folds, a cell takes several times that.
std::optional<HardCell> unless_short(const HardRequest& request, const Scene& scene, int frames);

}  // namespace musclebench

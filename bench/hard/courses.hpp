#pragma once

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

/// As `moved`. Throws TakesTooLong where by its first frames so many like runs would take more CPU time than 4.8 s in
/// the short run, which ends within some four minutes for all backends, or 10 min in the long one; or the detections of
/// one frame more than 20 or 100 s.
MovedScene moved_in_time(const HardRequest& request, Scene scene, int runs = 1);

}  // namespace musclebench

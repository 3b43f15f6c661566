#include "core/measure/arm_course.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace musclebench {

namespace {

constexpr double slowest_share = 0.25;

/// Of each frame: whether the joint turned fast enough since the one before.
std::vector<bool> turning_frames(std::span<const double> angles_rad) {
  double fastest = 0;
  for (std::size_t i = 1; i < angles_rad.size(); ++i) {
    fastest = std::max(fastest, std::abs(angles_rad[i] - angles_rad[i - 1]));
  }
  std::vector<bool> turning(angles_rad.size(), false);
  for (std::size_t i = 1; i < angles_rad.size(); ++i) {
    turning[i] = fastest > 0 && std::abs(angles_rad[i] - angles_rad[i - 1]) >= slowest_share * fastest;
  }
  return turning;
}

}  // namespace

ArmCourse arm_course(std::span<const FibreFrame> frames) {
  ArmCourse course;
  if (frames.empty()) return course;
  course.mean_lengths_m.resize(frames.front().muscles.size());
  for (const FibreFrame& frame : frames) {
    course.angles_rad.push_back(frame.angle_rad);
    for (std::size_t muscle = 0; muscle < frame.muscles.size(); ++muscle) {
      const std::vector<double>& lengths_m = frame.muscles[muscle].lengths_m;
      course.mean_lengths_m[muscle].push_back(std::accumulate(lengths_m.begin(), lengths_m.end(), 0.0) /
                                              static_cast<double>(lengths_m.size()));
    }
  }
  return course;
}

ArmError arm_error(const ArmCourse& course, const ArmCourse& exact) {
  ArmError error;
  double squares_m2 = 0;
  const std::size_t frames = std::min(course.angles_rad.size(), exact.angles_rad.size());
  const auto first = [&](const std::vector<double>& all) { return std::span(all).first(frames); };
  const std::vector<bool> turning = turning_frames(first(exact.angles_rad));
  for (std::size_t muscle = 0; muscle < exact.mean_lengths_m.size(); ++muscle) {
    const auto ours = moment_arms(first(course.angles_rad), first(course.mean_lengths_m[muscle]));
    const auto theirs = moment_arms(first(exact.angles_rad), first(exact.mean_lengths_m[muscle]));
    for (std::size_t i = 0; i < frames; ++i) {
      if (!turning[i] || !ours[i] || !theirs[i]) continue;
      const double off_m = std::abs(ours[i]->arm_m - theirs[i]->arm_m);
      squares_m2 += off_m * off_m;
      error.largest_m = std::max(error.largest_m, off_m);
      ++error.frames;
    }
  }
  if (error.frames > 0) error.rms_m = std::sqrt(squares_m2 / error.frames);
  return error;
}

}  // namespace musclebench

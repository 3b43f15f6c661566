#include "bench/hard/courses.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/machine_state.hpp"
#include "core/base/scoped_timer.hpp"

namespace musclebench {

void repeat_motions(Scene& scene, const CourseFrames& frames, int times) {
  for (BoneMotion& motion : scene.motions) {
    for (BoneRotation& rotation : motion.rotations) {
      const double rest_rad = rotation.angles_rad.front();
      const double flexed_rad = rotation.angles_rad.back();
      rotation.there_and_back = false;
      rotation.times = {0};
      rotation.angles_rad = {rest_rad};
      for (int i = 0; i < times; ++i) {
        const double start = i * frames.all();
        rotation.times.insert(rotation.times.end(),
                              {start + 0.5 * frames.moving, start + frames.moving, start + frames.all()});
        rotation.angles_rad.insert(rotation.angles_rad.end(), {flexed_rad, rest_rad, rest_rad});
      }
    }
  }
}

double rms_gap_m(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  double sum_m2 = 0;
  for (std::size_t i = 0; i < from.size(); ++i) sum_m2 += (to[i] - from[i]).squaredNorm();
  return std::sqrt(sum_m2 / static_cast<double>(from.size()));
}

namespace {

/// What one detection of all nodes takes, by that of a few, s: too long where it depends on how many there are.
double detection_s(const HardRequest& request, const Scene& scene) {
  const auto backend = request.backend.make(request.parameters());
  const std::vector<Vec3>& positions = scene.muscle_mesh.vertices;
  backend->build(scene.bones, scene.muscle_mesh, 1);
  backend->update(std::vector<RigidMotion>(scene.bones.size()), positions);
  std::vector<int> few(std::min<std::size_t>(positions.size(), 10));
  std::iota(few.begin(), few.end(), 0);
  std::vector<Contact> contacts;
  const Nanoseconds start_ns = monotonic_now_ns();
  backend->detect(positions, few, contacts);
  return 1e-9 * static_cast<double>(monotonic_now_ns() - start_ns) * static_cast<double>(positions.size()) /
         static_cast<double>(few.size());
}

}  // namespace

MovedScene moved_in_time(const HardRequest& request, Scene scene, int runs) {
  const double most_s = request.whole ? 900 : 5;
  constexpr double too_long_s = 2;  // for a frame to be tried, which has many detections
  if (const double once_s = detection_s(request, scene); once_s > too_long_s) {
    throw TakesTooLong{fmt::format("would take some {:.0f} s a detection", once_s)};
  }
  const int frames = scene.loop.frames;
  constexpr int trusted_frames = 3;
  Nanoseconds first_ended_ns = 0;  // the first frame fills the caches
  return moved(request, std::move(scene), 1, [&](int frames_done) {
    const Nanoseconds now_ns = process_cpu_ns();
    if (frames_done <= 1) first_ended_ns = now_ns;
    if (frames_done < trusted_frames) return false;
    const double whole_s = 1e-9 * static_cast<double>(now_ns - first_ended_ns) * runs * frames / (frames_done - 1);
    if (whole_s <= most_s) return false;
    throw TakesTooLong{
        fmt::format("would take {:.0f} s{}", whole_s, request.whole ? "" : ": in the long run only (--all)")};
  });
}

}  // namespace musclebench

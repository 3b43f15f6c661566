#include "bench/hard/courses.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/machine_state.hpp"

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

/// CPU time of one detection of all nodes, s: where nodes are asked one by one, by that of a few.
double detection_s(const HardRequest& request, const Scene& scene) {
  const auto backend = request.backend.make(request.parameters());
  const std::vector<Vec3>& positions = scene.muscle_mesh.vertices;
  backend->build(scene.bones, scene.muscle_mesh, 1);
  backend->update(std::vector<RigidMotion>(scene.bones.size()), positions);
  std::vector<int> asked(backend->capabilities().point_queries ? std::min<std::size_t>(positions.size(), 10)
                                                               : positions.size());
  std::iota(asked.begin(), asked.end(), 0);
  std::vector<Contact> contacts;
  const Nanoseconds start_ns = process_cpu_ns();
  backend->detect(positions, asked, contacts);
  return 1e-9 * static_cast<double>(process_cpu_ns() - start_ns) * static_cast<double>(positions.size()) /
         static_cast<double>(asked.size());
}

}  // namespace

MovedScene moved_in_time(const HardRequest& request, Scene scene, int runs) {
  const double most_s = request.whole ? 600 : 4.8;
  const double most_frame_s = request.whole ? 100 : 20;
  if (const double frame_s = detection_s(request, scene) * scene.loop.substeps; frame_s > most_frame_s) {
    throw TakesTooLong(fmt::format("would take some {:.0f} s a frame", frame_s));
  }
  const int frames = scene.loop.frames;
  constexpr int tried_frames = 3;
  Nanoseconds first_ended_ns = 0;
  return moved(request, std::move(scene), 1, [&](int frames_done) {
    // The first frame fills the caches. What is slow later, where the muscle folds, is what a case is about.
    if (frames_done == 1) first_ended_ns = process_cpu_ns();
    if (frames_done != tried_frames) return;
    const double tried_s = 1e-9 * static_cast<double>(process_cpu_ns() - first_ended_ns);
    const double whole_s = tried_s * runs * frames / (tried_frames - 1);
    if (whole_s <= most_s) return;
    throw TakesTooLong(fmt::format("would take {:.1f} s of at most {:.1f}{}", whole_s, most_s,
                                   request.whole ? "" : ": in the long run only (--all)"));
  });
}

}  // namespace musclebench

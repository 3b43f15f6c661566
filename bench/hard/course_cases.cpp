#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <hwy/targets.h>

#include "bench/hard/moved_scene.hpp"

// Cases of whole courses: what adds up over many frames, and what a run may not depend on.
namespace musclebench {

namespace {

constexpr const char* flexed_muscle = "synthetic/adductor_brevis";
constexpr int moving_frames = 40;
constexpr int resting_frames = 25;  // half a second of the preset: the muscle comes to rest

double rms_gap_m(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  double sum_m2 = 0;
  for (std::size_t i = 0; i < from.size(); ++i) sum_m2 += (to[i] - from[i]).squaredNorm();
  return std::sqrt(sum_m2 / static_cast<double>(from.size()));
}

Vec3 centre_of(const std::vector<Vec3>& positions) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& position : positions) sum += position;
  return sum / static_cast<double>(positions.size());
}

SceneChoice flexion(std::int64_t frames) {
  SceneChoice choice = scene_of(flexed_muscle);
  choice.preset = "standard";
  choice.loop_overrides["frames"] = frames;
  return choice;
}

/// The motion of each bone so many times one after the other, each with its rest.
void repeat_motions(Scene& scene, int times) {
  for (BoneMotion& motion : scene.motions) {
    if (motion.angles_rad.empty()) continue;
    const double rest_rad = motion.angles_rad.front();
    const double flexed_rad = motion.angles_rad.back();
    motion.there_and_back = false;
    motion.times = {0};
    motion.angles_rad = {rest_rad};
    for (int i = 0; i < times; ++i) {
      const double start = i * (moving_frames + resting_frames);
      motion.times.insert(motion.times.end(),
                          {start + 0.5 * moving_frames, start + moving_frames, start + moving_frames + resting_frames});
      motion.angles_rad.insert(motion.angles_rad.end(), {flexed_rad, rest_rad, rest_rad});
    }
  }
}

/// Of the short run, which ends within two minutes for all backends: a cell in which one alone would take a good part
/// of that, by what one substep takes.
std::optional<HardCell> unless_short(const HardRequest& request, SceneChoice choice, int frames) {
  constexpr double most_s = 20;
  if (request.whole) return std::nullopt;
  const int substeps = load_scene(choice).loop.substeps;
  choice.loop_overrides["frames"] = std::int64_t{1};
  choice.loop_overrides["substeps"] = std::int64_t{1};
  const double frame_s =
      1e-9 * substeps * static_cast<double>(moved(request, choice).result.records.front().times.frame_ns);
  if (frame_s * frames <= most_s) return std::nullopt;
  return not_applicable(fmt::format("would take {:.0f} s: in the long run only (--all)", frame_s * frames));
}

HardCell long_run(const HardRequest& request) {
  return watched(request, true, [&] {
    const int flexions = request.whole ? 50 : 2;
    constexpr int frames_of_one = moving_frames + resting_frames;
    if (const std::optional<HardCell> left_out = unless_short(request, flexion(1), frames_of_one * flexions)) {
      return *left_out;
    }
    const MovedScene run = moved(request, flexion(std::int64_t{frames_of_one} * flexions), 1,
                                 [&](Scene& scene) { repeat_motions(scene, flexions); });
    if (run.result.status == "diverged") return HardCell{Verdict::breaks, run.said(), {}};
    const std::vector<Vec3>& first = run.positions(frames_of_one);
    const std::vector<Vec3>& last = run.positions(run.result.snapshots.size() - 1);
    return judged(
        {{fmt::format("difference (RMS) of return {} from the first, over the diagonal", flexions),
          rms_gap_m(first, last) / run.diagonal_m(), 1e-3},
         {"difference (RMS) of the first return from rest", 1e3 * rms_gap_m(run.positions(0), first), 2, "mm"}},
        request, run.said());
  });
}

HardCell sensitivity(const HardRequest& request) {
  return watched(request, true, [&] {
    SceneChoice choice = flexion(moving_frames);
    if (const std::optional<HardCell> left_out = unless_short(request, choice, 2 * moving_frames)) return *left_out;
    const MovedScene run = moved(request, choice);
    choice.loop_overrides["start_noise_m"] = 1e-12;
    const MovedScene other = moved(request, choice);
    const std::size_t last = run.result.snapshots.size() - 1;
    return judged({{"largest difference of the shapes at full flexion",
                    1e3 * largest_gap_m(run.positions(last / 2), other.positions(last / 2)), 0.1, "mm"},
                   {"largest difference after the return",
                    1e3 * largest_gap_m(run.positions(last), other.positions(last)), 0.1, "mm"}},
                  request, run.said());
  });
}

/// Frictionless: along the groove the ball falls freely, g t^2 / 2, in steps of the loop g t (t + dt) / 2.
HardCell groove(const HardRequest& request) {
  return watched(request, true, [&] {
    const MovedScene run = moved(request, scene_of("hard/groove"));
    const std::size_t last = run.result.snapshots.size() - 1;
    const LoopParameters& loop = run.scene.loop;
    const double passed_s = loop.time_step_s * loop.substeps * static_cast<double>(last);
    const double free_m = 0.5 * passed_s * (passed_s + loop.time_step_s);
    const double gone_m = (centre_of(run.positions(last)) - centre_of(run.positions(0))).y();
    return judged({{"share of the free path that the ball's centre lacks", 1 - gone_m / free_m, 0.1}}, request,
                  run.said());
  });
}

HardCell same_state_for_targets(const HardRequest& request) {
  return watched(request, true, [&] {
    std::vector<std::string> hashes;
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      hwy::SetSupportedTargetsForTest(target);
      hashes.push_back(moved(request, scene_of("hard/step_size")).result.state_hash);
    }
    hwy::SetSupportedTargetsForTest(0);
    const auto other = std::ranges::count_if(hashes, [&](const std::string& hash) { return hash != hashes.front(); });
    return judged({{fmt::format("of {} SIMD targets, those that end in other bits than the widest", hashes.size()),
                    static_cast<double>(other), 0, "targets"}},
                  request, "", MayRefuse::nobody);
  });
}

constexpr std::array cases_of_courses = {
    HardCase{.id = "groove",
             .what = "A ball in the groove between two bones is pulled along it, without friction.",
             .why = "A node between two bones, or between cells, is held by what it is pushed out of (paper, Fig. 5).",
             .bar = "each node goes at least 90 % of the way of free fall",
             .scene = "hard/groove",
             .run = groove},
    HardCase{.id = "long-run",
             .what = "A synthetic adductor brevis, preset standard, is flexed there and back twice (50 in the long "
                     "run), with half "
                     "a second of rest after each.",
             .why = "What each flexion leaves behind adds up.",
             .bar = "RMS from the first to the last return 1e-3 of the diagonal; from rest to the first return 2 mm",
             .scene = flexed_muscle,
             .run = long_run},
    HardCase{
        .id = "sensitivity",
        .what = "The same muscle flexed once, and again with nodes that start up to 1e-12 m off.",
        .why = "What the loop makes of rounding is the floor of every comparison of shapes (review 12: 7 to 9 mm).",
        .bar = "shapes within 0.1 mm at full flexion and after the return",
        .scene = flexed_muscle,
        .run = sensitivity},
    HardCase{
        .id = "other-cpu",
        .what =
            "A ball that a plate sweeps along, with each SIMD instruction set that this CPU has, forced one by one.",
        .why = "Results of two machines can be compared only where vector width changes no bit.",
        .bar = "the same bits at the end",
        .scene = "hard/step_size",
        .run = same_state_for_targets},
};

}  // namespace

std::span<const HardCase> course_cases() { return cases_of_courses; }

}  // namespace musclebench

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <hwy/targets.h>

#include "bench/hard/courses.hpp"
#include "bench/hard/moved_scene.hpp"
#include "bench/hard/sane_figures.hpp"

// Cases of whole courses: what adds up over many frames, and what a run may not depend on.
namespace musclebench {

namespace {

/// The judge's budget is 18 times a frame as the scene's size foretells it. A frame in which a clearance cache has
/// nothing to do, as here, takes a third of that.
constexpr double most_times_a_frame = 60;

constexpr const char* flexed_muscle = "synthetic/adductor_brevis";
constexpr CourseFrames course_frames{.moving = 40, .resting = 25};

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

HardCell long_run(const HardRequest& request) {
  return watched(request, true, [&] {
    const int flexions = request.whole ? 50 : 2;
    constexpr int frames_of_one = course_frames.all();
    Scene scene = load_scene(flexion(std::int64_t{frames_of_one} * flexions));
    repeat_motions(scene, course_frames, flexions);
    const MovedScene run = moved_in_time(request, std::move(scene));
    if (run.result.status == "diverged") return HardCell{Verdict::breaks, run.said(), {}};
    const std::vector<Vec3>& first = run.positions(frames_of_one);
    const std::vector<Vec3>& last = run.positions(run.result.snapshots.size() - 1);
    return judged(
        with_sane_figures(
            {{fmt::format("difference (RMS) of return {} from the first, over the diagonal", flexions),
              rms_gap_m(first, last) / run.diagonal_m(), 1e-3},
             {"difference (RMS) of the first return from rest", 1e3 * rms_gap_m(run.positions(0), first), 2, "mm"}},
            run, request),
        request, run.said());
  });
}

HardCell sensitivity(const HardRequest& request) {
  return watched(request, true, [&] {
    const int frames = request.whole ? course_frames.moving : 24;
    Scene scene = load_scene(flexion(frames));
    const MovedScene run = moved_in_time(request, scene, 2);
    scene.loop.start_noise_m = 1e-12;
    const MovedScene other = moved(request, std::move(scene));
    const std::size_t last = run.result.snapshots.size() - 1;
    return judged(
        with_sane_figures({{"largest difference of the shapes at full flexion",
                            1e3 * largest_gap_m(run.positions(last / 2), other.positions(last / 2)), 0.1, "mm"},
                           {"largest difference after the return",
                            1e3 * largest_gap_m(run.positions(last), other.positions(last)), 0.1, "mm"}},
                          run, request),
        request, run.said());
  });
}

/// Frictionless: along the groove the ball falls freely, g t^2 / 2, in steps of the loop g t (t + dt) / 2.
HardCell groove(const HardRequest& request) {
  return watched(request, true, [&] {
    SceneChoice choice = scene_of("hard/groove");
    if (!request.whole) choice.loop_overrides["frames"] = std::int64_t{20};
    const MovedScene run = moved(request, choice);
    const std::size_t last = run.result.snapshots.size() - 1;
    const LoopParameters& loop = run.scene.loop;
    const double passed_s = loop.time_step_s * loop.substeps * static_cast<double>(last);
    const double free_m = 0.5 * passed_s * (passed_s + loop.time_step_s);
    const double gone_m = (centre_of(run.positions(last)) - centre_of(run.positions(0))).y();
    return judged(with_sane_figures({{"share of the free path by which the ball's centre is off",
                                      std::abs(1 - gone_m / free_m), 0.1}},
                                    run, request),
                  request, run.said());
  });
}

/// CPU time of all frames, judged or not: the shorter of two.
Nanoseconds frames_ns(const HardRequest& request, bool judge, const EditScene& edit,
                      std::vector<StepRecord>* records = nullptr) {
  Nanoseconds shortest_ns = std::numeric_limits<Nanoseconds>::max();
  for (int i = 0; i < 2; ++i) {
    Scene scene = load_scene(scene_of("hard/flush"));
    if (edit) edit(scene);
    if (request.spoil) request.spoil(scene);
    const Parameters parameters = request.parameters();
    RunCase run{{scene, request.backend, parameters, 1}};
    run.responses = choose_responses("", scene, request.backend, parameters);
    run.judge = judge;
    const RunResult result = run_case(run, [](int) {});
    shortest_ns = std::min(shortest_ns, result.cpu_after_ns - result.cpu_before_ns);
    if (records != nullptr) *records = result.records;
  }
  return shortest_ns;
}

HardCell judge_flush(const HardRequest& request) {
  return watched(request, true, [&] {
    std::vector<HardFigure> figures;
    const auto open = [](Scene& scene) {
      // Every tenth triangle is missing.
      std::vector<Triangle> kept;
      for (std::size_t t = 0; t < scene.muscle_mesh.triangles.size(); ++t) {
        if (t % 10 != 0) kept.push_back(scene.muscle_mesh.triangles[t]);
      }
      scene.muscle_mesh.triangles = kept;
      scene.muscles.front().body.last_triangle = kept.size();
    };
    for (const auto& [words, edit] :
         {std::pair<std::string, EditScene>("closed", {}), std::pair<std::string, EditScene>("open", open)}) {
      std::vector<StepRecord> records;
      const auto judged_ns = static_cast<double>(frames_ns(request, true, edit, &records));
      const auto plain_ns = static_cast<double>(frames_ns(request, false, edit));
      figures.push_back({words + " muscle: time of a frame with its judgement over that without", judged_ns / plain_ns,
                         most_times_a_frame});
      const auto unbounded = std::ranges::count_if(
          records, [](const StepRecord& record) { return !(record.surface_depth_bound_m >= record.surface_depth_m); });
      figures.push_back(
          {words + " muscle: frames whose surface depth has no bound", static_cast<double>(unbounded), 0, "frames"});
      figures.push_back(without_contact(records, words + " muscle"));
    }
    return judged(std::move(figures), request, "", MayRefuse::nobody);
  });
}

/// All lengths of the scene times `factor`, and what it has per length.
void scale_scene(Scene& scene, double factor) {
  const auto scaled = [&](std::vector<Vec3>& vertices) {
    for (Vec3& vertex : vertices) vertex *= factor;
  };
  scaled(scene.muscle_mesh.vertices);
  for (Muscle& muscle : scene.muscles) scaled(muscle.file.mesh.vertices);
  for (std::size_t bone = 0; bone < scene.bones.size(); ++bone) {
    scaled(scene.bones[bone].surface.mesh.vertices);
    scaled(scene.bone_meshes[bone].mesh.vertices);
    for (BoneRotation& rotation : scene.motions[bone].rotations) rotation.centre_m *= factor;
  }
}

HardCell scaled_run(const HardRequest& request) {
  return watched(request, true, [&] {
    SceneChoice choice = scene_of("hard/step_size");
    choice.loop_overrides["frames"] = std::int64_t{request.whole ? 64 : 40};
    const MovedScene usual = moved(request, choice);
    const std::size_t last = usual.result.snapshots.size() - 1;
    std::vector<HardFigure> figures{without_contact(usual.result.records)};
    for (const double factor :
         request.whole ? std::vector<double>{0x1p10, 0x1p-10, 1e3, 1e-3} : std::vector<double>{0x1p10, 1e-3}) {
      const MovedScene other = moved(request, choice, 1, [&](Scene& scene) { scale_scene(scene, factor); });
      std::vector<Vec3> back = other.positions(last);
      for (Vec3& position : back) position /= factor;
      int exponent = 0;
      const bool is_power_of_two = std::frexp(factor, &exponent) == 0.5;
      figures.push_back({fmt::format("scaled by {:g}: largest difference of the shapes, over the diagonal", factor),
                         largest_gap_m(usual.positions(last), back) / usual.diagonal_m(), is_power_of_two ? 0 : 1e-3});
    }
    return judged(std::move(figures), request, usual.said(), MayRefuse::nobody);
  });
}

HardCell same_state_for_targets(const HardRequest& request) {
  return watched(request, true, [&] {
    std::vector<std::string> hashes;
    HardFigure contactless;
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      hwy::SetSupportedTargetsForTest(target);
      SceneChoice choice = scene_of("hard/step_size");
      if (!request.whole) choice.loop_overrides["frames"] = std::int64_t{8};
      const MovedScene run = moved(request, choice);
      hashes.push_back(run.result.state_hash);
      contactless = without_contact(run.result.records);
    }
    hwy::SetSupportedTargetsForTest(0);
    const auto other = std::ranges::count_if(hashes, [&](const std::string& hash) { return hash != hashes.front(); });
    return judged({{fmt::format("of {} SIMD targets, those that end in other bits than the widest", hashes.size()),
                    static_cast<double>(other), 0, "targets"},
                   contactless},
                  request, "", MayRefuse::nobody);
  });
}

constexpr std::array cases_of_courses = {
    HardCase{.id = "groove",
             .what = "A ball in the groove between two bones is pulled along it, without friction.",
             .why = "A node between two bones, or between cells, is held by what it is pushed out of (paper, Fig. 5).",
             .bar = "the centre goes the way of free fall within 10 %, the sane figures",
             .scene = "hard/groove",
             .run = groove},
    HardCase{.id = "long-run",
             .what = "A synthetic adductor brevis, preset standard, is flexed there and back twice (50 in the long "
                     "run), with half "
                     "a second of rest after each.",
             .why = "What each flexion leaves behind adds up.",
             .bar = "RMS from the first to the last return 1e-3 of the diagonal; from rest to the first return 2 mm; "
                    "the sane figures",
             .scene = flexed_muscle,
             .run = long_run},
    HardCase{
        .id = "sensitivity",
        .what = "The same muscle flexed once, and again with nodes that start up to 1e-12 m off.",
        .why = "What the loop makes of rounding is the floor of every comparison of shapes (review 12: 7 to 9 mm).",
        .bar = "shapes within 0.1 mm at full flexion and after the return, the sane figures",
        .scene = flexed_muscle,
        .run = sensitivity},
    HardCase{.id = "scaled-run",
             .what = "A ball that a plate sweeps along, and both a thousand times as large and as small. In the long "
                     "run each of them by a power of two and by one of ten.",
             .why = "A tolerance in metres anywhere in the loop, its effects or a backend shows.",
             .bar = "by a power of two the same bits, by one of ten within 1e-3 of the diagonal",
             .scene = "hard/step_size",
             .left_out_because = "shapes are compared, of runs that are judged in step-size-unguarded",
             .run = scaled_run},
    HardCase{.id = "judge-flush",
             .what =
                 "A muscle fills the groove of a bone, its faces on the bone's; once more with every tenth triangle "
                 "missing.",
             .why = "No part of such a face is clearly inside or outside, and a judge that splits faces until one is "
                    "never ends (review 13).",
             .bar = "judging a frame costs at most 60 times the frame, and says the bound that is left",
             .scene = "hard/flush",
             .left_out_because = "the time of judging is measured, of a muscle that is in its bone on purpose",
             .run = judge_flush},
    HardCase{
        .id = "other-cpu",
        .what =
            "A ball that a plate sweeps along, with each SIMD instruction set that this CPU has, forced one by one.",
        .why = "Results of two machines can be compared only where vector width changes no bit.",
        .bar = "the same bits at the end",
        .scene = "hard/step_size",
        .left_out_because = "bits are compared, of runs that are judged in step-size-unguarded",
        .run = same_state_for_targets},
};

}  // namespace

std::span<const HardCase> course_cases() { return cases_of_courses; }

}  // namespace musclebench

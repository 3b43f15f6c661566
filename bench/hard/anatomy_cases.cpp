#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "bench/cases/scene_source.hpp"
#include "bench/hard/courses.hpp"
#include "bench/hard/run_figures.hpp"
#include "bench/hard/sane_figures.hpp"
#include "core/measure/crossings.hpp"
#include "core/mesh/mesh_size.hpp"

// Cases of real muscles, for which the anatomical data are needed.
namespace musclebench {

namespace {

constexpr CourseFrames whole_course{.moving = 90, .resting = 25};

/// Nothing where the data are there.
std::optional<HardCell> unless_data(const HardRequest& request) {
  if (data_folder(request.data)) return std::nullopt;
  return not_applicable("needs the real anatomy: --data (datasets/README.md: Real anatomy)");
}

SceneChoice flexion_of(const std::string& muscle, const HardRequest& request, int flexions) {
  SceneChoice choice = scene_of("lhdl/" + muscle);
  choice.preset = "standard";
  choice.data = request.data;
  choice.loop_overrides["frames"] = std::int64_t{flexions} * whole_course.all();
  choice.effect_overrides.push_back({.location = "hard cases", .name = "self_contact"});
  return choice;
}

std::vector<std::string> muscles_of(const HardRequest& request, const std::string& of_the_short_run) {
  if (!request.whole) return {of_the_short_run};
  return {"adductor_brevis", "iliacus", "gluteus_medius", "gluteus_maximus"};
}

/// `run_of(muscle)` of each; `figures_of(muscle, run)` and the sane ones.
template <typename Run, typename Figures>
HardCell each_moved(const HardRequest& request, const std::vector<std::string>& muscles, const Run& run_of,
                    const Figures& figures_of, const SaneBars& bars = {}) {
  if (std::optional<HardCell> left_out = unless_data(request)) return *left_out;
  return watched_runs(request, true, [&](RunFigures& figures) {
    for (const std::string& muscle : muscles) {
      const MovedScene run = run_of(muscle);
      if (run.result.status == "diverged") {
        figures.add({fmt::format("{}: runs that diverge", muscle), 1, 0});
      } else {
        figures.add_run(run, muscle, figures_of(muscle, run), bars);
      }
    }
  });
}

/// So many flexions of each muscle.
template <typename Figures>
HardCell flexed(const HardRequest& request, const std::vector<std::string>& muscles, int flexions,
                const Figures& figures_of, const SaneBars& bars = {}) {
  const auto run_of = [&](const std::string& muscle) {
    Scene scene = load_scene(flexion_of(muscle, request, flexions));
    repeat_motions(scene, whole_course, flexions);
    return moved_in_time(request, std::move(scene));
  };
  return each_moved(request, muscles, run_of, figures_of, bars);
}

HardCell return_to_rest(const HardRequest& request) {
  const std::vector<std::string> muscles = muscles_of(request, "adductor_brevis");
  const auto returned = [&](int flexions) {
    return flexed(request, muscles, flexions, [flexions](const std::string& muscle, const MovedScene& run) {
      const std::vector<Vec3>& first = run.positions(whole_course.all());
      std::vector<HardFigure> figures{{fmt::format("{}: difference (RMS) of the first return from rest", muscle),
                                       1e3 * rms_gap_m(run.positions(0), first), 2, "mm"}};
      if (flexions > 1) {
        figures.push_back(
            {fmt::format("{}: difference (RMS) of return {} from the first, over the diagonal", muscle, flexions),
             rms_gap_m(first, run.positions(run.result.snapshots.size() - 1)) / run.diagonal_m(), 1e-3});
      }
      return figures;
    });
  };
  // Where one return leaves folds, more of them come with each, and contact of the muscle with itself takes hours.
  HardCell once = returned(1);
  if (!request.whole || once.verdict != Verdict::holds) return once;
  HardCell often = returned(50);
  return often.verdict == Verdict::not_applicable ? without(std::move(once), "50 returns: " + often.detail) : often;
}

HardCell self_intersection(const HardRequest& request) {
  const std::vector<std::string> muscles = muscles_of(request, "iliacus");
  return flexed(
      request, muscles, 1,
      [](const std::string& muscle, const MovedScene& run) {
        const auto count = [&](std::size_t frame) {
          return static_cast<double>(count_self_crossings({run.positions(frame), run.scene.muscle_mesh.triangles}));
        };
        const auto triangles = static_cast<double>(run.scene.muscle_mesh.triangles.size());
        return std::vector<HardFigure>{
            {fmt::format("{}: share of triangles that pass through others at full flexion", muscle),
             count(whole_course.moving / 2) / triangles, 1e-3},
            {fmt::format("{}: triangles that do after the return, beyond those at rest", muscle),
             std::max(0.0, count(whole_course.all()) - count(0)), 0, "triangles"}};
      },
      {.passing = false});
}

/// The part of an OpenSim model's motion table from rest to its end, there and back.
BoneRotation away_from_rest(const MotionTable& table, const Vec3& axis, const Vec3& centre_m) {
  BoneRotation rotation;
  rotation.axis = axis;
  rotation.centre_m = centre_m;
  for (std::size_t row = 0; row < table.times.size(); ++row) {
    if (table.values[row] < 0) continue;
    rotation.times.push_back(table.times[row]);
    rotation.angles_rad.push_back(table.values[row] / degrees_per_radian);
  }
  return rotation;
}

/// The data's own tables of adduction about an axis across flexion and shaft, and of rotation about the shaft, along
/// with the flexion.
void add_other_rotations(Scene& scene, const std::filesystem::path& data) {
  const auto table_of = [&](const std::string& name) {
    return read_motion_table(data / "upstream/3d-muscles/a_MSK_model/b_kinematics" / ("hip_" + name + ".mot"),
                             "hip_" + name + "_r");
  };
  for (std::size_t bone = 0; bone < scene.bones.size(); ++bone) {
    if (!scene.motions[bone].turns()) continue;
    const BoneRotation flexion = scene.motions[bone].rotations.front();
    const Vec3 middle = bounding_box(scene.bones[bone].surface.mesh.vertices).center() - flexion.centre_m;
    const Vec3 shaft = (middle - middle.dot(flexion.axis) * flexion.axis).normalized();
    std::vector<BoneRotation>& rotations = scene.motions[bone].rotations;
    rotations.push_back(away_from_rest(table_of("adduction"), flexion.axis.cross(shaft), flexion.centre_m));
    rotations.push_back(away_from_rest(table_of("rotation"), shaft, flexion.centre_m));
  }
}

HardCell far_flexion(const HardRequest& request) {
  const auto run_of = [&](const std::string& muscle) {
    SceneChoice choice = flexion_of(muscle, request, 1);
    choice.motion_overrides = {{"to_deg", 120.0}};
    choice.effect_overrides.push_back({.location = "hard cases", .name = "tunnelling_guard"});
    Scene scene = load_scene(choice);
    add_other_rotations(scene, *data_folder(request.data));
    return moved_in_time(request, std::move(scene));
  };
  return each_moved(request, muscles_of(request, "adductor_brevis"), run_of,
                    [](const std::string&, const MovedScene&) { return std::vector<HardFigure>{}; });
}

constexpr std::array cases_of_anatomy = {
    HardCase{
        .id = "return-to-rest",
        .what = "The real adductor brevis is flexed there and back, preset standard with self-contact, and rests for "
                "half a second. In the long run all four muscles are, 50 times where once holds.",
        .why = "Folds that lock and nodes on the wrong side do not come back (15 mm on the gluteus maximus, once).",
        .bar = "RMS to rest 2 mm; from the first to the 50th return 1e-3 of the diagonal; the sane figures",
        .scene = "",
        .run = return_to_rest},
    HardCase{.id = "far-flexion",
             .what = "The real adductor brevis (in the long run all four muscles) under flexion to 120 degrees, with "
                     "the tunnelling guard. Its model's motion tables add 40 degrees of adduction and 30 of rotation.",
             .why = "Beyond the paper's 90 degrees muscles are wound around bones and pinched between them.",
             .bar = "no node on the wrong side of a bone, the sane figures",
             .scene = "",
             .run = far_flexion},
    HardCase{.id = "self-intersection",
             .what = "The real iliacus (in the long run all four muscles) in the same flexion.",
             .why = "Folds of a muscle pass through each other (436 of 13,858 triangles, once), and then they lock.",
             .bar = "at full flexion at most 0.1 % of the triangles, none more after the return than at rest; the sane "
                    "figures, "
                    "without those that pass",
             .scene = "",
             .run = self_intersection},
};

}  // namespace

std::span<const HardCase> anatomy_cases() { return cases_of_anatomy; }

}  // namespace musclebench

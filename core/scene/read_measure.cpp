#include "core/scene/read_measure.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/input_error.hpp"
#include "core/scene/scene_warnings.hpp"

namespace musclebench {

namespace {

/// The slope of a length over an angle takes three.
constexpr int least_frames = 3;
constexpr double most_fibres = 100'000;
/// Where a scene wants moment arms and does not say of how many.
constexpr int fibres_for_arms = 100;

/// Whether two bones turn as one: as the bones of a foot do at the ankle.
bool turn_alike(const BoneMotion& one, const BoneMotion& other) {
  return std::ranges::equal(one.rotations, other.rotations, [](const BoneRotation& a, const BoneRotation& b) {
    return a.axis == b.axis && a.centre_m == b.centre_m && a.times == b.times && a.angles_rad == b.angles_rad &&
           a.there_and_back == b.there_and_back;
  });
}

void require_one_axis(const Scene& scene, const std::string& location) {
  std::vector<std::string> turning;
  const BoneMotion* first = nullptr;
  bool is_one = true;
  for (std::size_t bone = 0; bone < scene.bones.size(); ++bone) {
    if (!scene.motions[bone].turns()) continue;
    turning.push_back("'" + scene.bones[bone].name + "'");
    if (std::ranges::count_if(scene.motions[bone].rotations, &BoneRotation::turns) > 1) {
      throw InputError(location,
                       fmt::format("needs one axis for moment arms, and bone {} turns about several; keep one "
                                   "of its [[bone.motion]], or leave fibres out",
                                   turning.back()));
    }
    if (first == nullptr) first = &scene.motions[bone];
    is_one = is_one && turn_alike(*first, scene.motions[bone]);
  }
  if (turning.empty()) {
    throw InputError(location,
                     "needs a motion: moment arms are about the axis that a bone turns about, and none turns; "
                     "give one a [bone.motion], or leave fibres out");
  }
  if (!is_one) {
    throw InputError(location, fmt::format("needs one axis for moment arms, and bones {} turn in different ways; let "
                                           "one of them stand, give all one motion, or leave fibres out",
                                           fmt::join(turning, " and ")));
  }
}

void require_frames(const Scene& scene, const std::string& location) {
  const int frames = scene.loop.frames - scene.loop.rest_frames;
  if (frames >= least_frames) return;
  throw InputError(location,
                   fmt::format("needs {} frames of motion or more for a moment arm, and the run has {}; raise "
                               "loop.frames",
                               least_frames, frames));
}

void require_two_areas(const Scene& scene, const std::string& location) {
  if (scene.attach_at_first_contact) return;  // known once a backend was asked
  const std::vector<BoundNode> bound = scene.bound_nodes();
  for (std::size_t muscle = 0; muscle < scene.muscles.size(); ++muscle) {
    const EndNodes ends = scene.end_nodes(muscle, bound);
    if (!ends.origin.empty() && !ends.insertion.empty()) continue;
    throw InputError(location, fmt::format("muscle '{}' has no two ends that fibres could run between: {}",
                                           scene.muscles[muscle].body.name, describe_missing_fibres(scene, muscle)));
  }
}

}  // namespace

void read_measure(const SceneRequest& request, const std::optional<TomlTable>& table, Scene& scene) {
  if (table) {
    table->allow_only({"fibres"});
    const double fibres = table->has("fibres") ? table->number("fibres", 0, most_fibres) : 0;
    if (fibres != std::floor(fibres)) throw InputError(table->location("fibres"), "has to be a whole number");
    scene.fibre_count = static_cast<int>(fibres);
  }
  if (request.fibres) {
    scene.fibre_count = request.fibres->count;
    scene.fibres_are_required = request.fibres->is_required;
  }
  std::string location = request.fibres ? request.fibres->option : table ? table->location("fibres") : "";
  if (scene.fibre_count == 0 && scene.wanted.moment_arm_m && !request.fibres) {
    scene.fibre_count = fibres_for_arms;
    location = "wanted.moment_arm_mm";
  }
  if (scene.fibre_count == 0) return;
  for (const auto& require : {require_one_axis, require_frames, require_two_areas}) {
    try {
      require(scene, location);
    } catch (const InputError& obstacle) {
      if (!scene.fibres_are_required) {
        scene.fibre_count = 0;
        scene.fibres_refused = obstacle.what();
        return;
      }
      if (!request.notes_obstacles) throw;
      scene.obstacles.emplace_back(obstacle.what());
    }
  }
}

}  // namespace musclebench

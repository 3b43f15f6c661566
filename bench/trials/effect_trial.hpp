#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/trials/required_figure.hpp"
#include "core/base/scoped_timer.hpp"
#include "core/measure/arm_course.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// A run of a whole motion that shows what a set of effects holds.
struct EffectTrial {
  std::vector<RequiredFigure> figures;  ///< at the worst moment of each requirement
  std::vector<std::vector<Vec3>>
      shapes;                ///< in up to eight frames, the last included; fewer where the run ended before
  ArmCourse arms = {};       ///< where the scene has fibres to follow
  std::string refusal = {};  ///< why the scene can't be run with these effects; empty: it was
  bool was_stopped = false;  ///< it had shown enough before its end
  bool judged_all_frames = false;
  int frames = 0;
  Nanoseconds cpu_ns = 0;

  [[nodiscard]] bool is_whole() const { return refusal.empty() && !was_stopped; }
};

/// Whether a figure of a frame shows enough of a trial; empty: none does.
using ShowsEnough = std::function<bool(const RequiredFigure& of_frame)>;

struct TrialRequest {
  ShowsEnough shows_enough = {};
  bool judges_all_frames = false;
};

/// Moves the muscles of `scene` with exact contacts, whatever backends it names. Nodes are followed through all frames;
/// surfaces and triangles are judged in some twenty, in all where that is asked for, the scene is small, or nothing
/// holds a muscle. Deterministic. `report` may be empty.
EffectTrial try_effects(const Scene& scene, const TrialRequest& request,
                        const std::function<void(int frames_done)>& report);

}  // namespace musclebench

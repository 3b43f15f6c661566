#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/cases/run_case.hpp"
#include "core/effects/requirement.hpp"
#include "core/measure/outcome.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// What a run shows of one requirement.
struct RequiredFigure {
  Requirement requirement = Requirement::whole_surface;
  double value = 0;        ///< in the unit of the limit: a ratio, a share, nodes and triangles, or m
  double limit = 0;        ///< the largest that holds
  std::string where = {};  ///< "iliacus", "iliacus in the femur"
  Moment when = {};
  bool is_bound = false;  ///< a depth that could not be excluded: not all was looked at

  [[nodiscard]] bool holds() const { return value <= limit; }
  /// How far beyond the limit, as a factor: 1 at the limit. Where nothing is allowed, one more than the value.
  [[nodiscard]] double excess() const;
  /// "the surface of iliacus in the femur is 0.24 mm deep at 62 degrees (frame 31; wanted 0.1 mm)"
  [[nodiscard]] std::string text() const;
  /// "0.24 mm"
  [[nodiscard]] std::string value_text() const;
};

/// Of one frame, those that a frame alone tells: the worst place of each. One that was not judged tells of its nodes.
std::vector<RequiredFigure> figures_of_frame(const Scene& scene, const StepRecord& frame, const MuscleAtRest& rest);

/// Of a judged run: each requirement that the scene has, at its worst moment. A run that diverged is not whole.
std::vector<RequiredFigure> figures_of_run(const Scene& scene, const RunResult& run);

/// Makes a judged run `suspect` that lacks what its scene wants (`[wanted]`), and says what.
void note_unmet_wants(const RunCase& run, RunResult& result);

/// The figure of a requirement; nothing where the scene has not that.
const RequiredFigure* find_figure(std::span<const RequiredFigure> figures, Requirement requirement);

/// RMS distance of the nodes of each muscle between two shapes, of the muscle in which it is largest.
struct LargestDistance {
  std::size_t body = 0;
  double distance_m = 0;
};
LargestDistance largest_rms_distance(std::span<const Body> bodies, std::span<const Vec3> from,
                                     std::span<const Vec3> to);

}  // namespace musclebench

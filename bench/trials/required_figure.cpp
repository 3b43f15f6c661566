#include "bench/trials/required_figure.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/base/quantity_words.hpp"
#include "core/measure/arm_course.hpp"
#include "core/measure/outcome_limits.hpp"

namespace musclebench {

namespace {

/// Of a fibre's length: less is what contact and rounding leave.
constexpr double least_slack = 1e-3;

/// "nodes through a bone" to "node through a bone": what is counted stands first.
std::string of_one(std::string counted) { return counted.erase(counted.find('s'), 1); }

/// Keeps the worst of each requirement.
void keep_worse(std::vector<RequiredFigure>& figures, RequiredFigure figure) {
  // What can't be told is no better than what is wrong.
  if (std::isnan(figure.value)) figure.value = std::numeric_limits<double>::infinity();
  const auto known = std::ranges::find(figures, figure.requirement, &RequiredFigure::requirement);
  if (known == figures.end()) {
    figures.push_back(std::move(figure));
  } else if (figure.excess() > known->excess()) {
    *known = std::move(figure);
  }
}

/// Of one frame of a scene.
class FrameFigures {
 public:
  FrameFigures(const Scene& scene, const StepRecord& frame, const MuscleAtRest& rest)
      : m_scene(scene), m_frame(frame), m_rest(rest) {}

  std::vector<RequiredFigure> take() && {
    add_nodes();
    if (!m_frame.judged) return std::move(m_figures);
    add({Requirement::whole_surface, m_frame.edge_stretch.p99, outcome_limit("edge_stretch_p99")});
    add_crossings();
    add_surfaces();
    return std::move(m_figures);
  }

 private:
  void add(RequiredFigure figure) {
    figure.when = {m_frame.frame, m_frame.angle_deg};
    keep_worse(m_figures, std::move(figure));
  }

  [[nodiscard]] std::string muscle(int index) const {
    return index < 0 ? "a muscle" : m_scene.muscles[static_cast<std::size_t>(index)].body.name;
  }
  [[nodiscard]] std::string bone(int index) const {
    return index < 0 ? "a bone" : "the " + m_scene.bones[static_cast<std::size_t>(index)].name;
  }
  void add_nodes() {
    add({Requirement::bone_passage, static_cast<double>(m_frame.tunnelled_nodes), 0, "nodes through a bone"});
    add_bone_depth(m_frame.depth.max_depth_m, m_frame.depth_bodies);
    if (m_frame.passed_nodes) {
      add({Requirement::muscle_passage, static_cast<double>(*m_frame.passed_nodes), 0, "nodes through another muscle"});
    }
    add_muscle_depths();
  }

  void add_bone_depth(double depth_m, const DeepBodies& bodies, bool is_bound = false) {
    add({.requirement = Requirement::bone_depth,
         .value = std::isfinite(depth_m) ? depth_m : 0,
         .limit = m_scene.wanted.surface_m,
         .where = fmt::format("{} in {}", muscle(bodies.muscle), bone(bodies.other)),
         .is_bound = is_bound});
  }

  /// No effect can undo how deep the scene lays two muscles into each other: settle_substeps or another place do.
  void add_muscle_depths() {
    for (std::size_t i = 0; i < m_frame.depths_in_muscles_m.size() && i < m_rest.crossing_pairs.size(); ++i) {
      const CrossingPair& pair = m_rest.crossing_pairs[i];
      if (pair.kind != CrossedSurface::muscle) continue;
      const double at_rest_m = i < m_rest.depths_in_muscles_m.size() ? m_rest.depths_in_muscles_m[i] : 0;
      add({Requirement::muscle_depth, m_frame.depths_in_muscles_m[i], std::max(m_scene.wanted.surface_m, at_rest_m),
           fmt::format("{} in {}", muscle(pair.muscle), muscle(pair.other))});
    }
  }

  /// Where the Referee could not look everywhere, the bound that is left counts: a depth below it can't be excluded.
  void add_surfaces() {
    const bool is_known = m_frame.judgement_complete;
    add_bone_depth(is_known ? m_frame.surface_depth_m : m_frame.surface_depth_bound_m, m_frame.surface_bodies,
                   !is_known);
    add_bone_depth(is_known ? m_frame.bone_vertex_depth_m : m_frame.bone_vertex_depth_bound_m,
                   m_frame.bone_vertex_bodies, !is_known);
    add_bone_depth(m_frame.thin_bone_depth_m, m_frame.thin_bone_bodies);
  }

  void add_crossings() {
    for (std::size_t i = 0; i < m_frame.beyond_rest.size() && i < m_rest.crossing_pairs.size(); ++i) {
      add_crossings(m_rest.crossing_pairs[i], m_frame.beyond_rest[i]);
    }
  }

  /// Where depths are judged, crossings are not: what touches is cut by rounding alone.
  void add_crossings(const CrossingPair& pair, int beyond_rest) {
    const int triangles = m_rest.muscles[static_cast<std::size_t>(pair.muscle)].triangles;
    const double allowed = m_scene.wanted.nothing_passes ? 0 : std::floor(outcome_limit("crossing_share") * triangles);
    const double value = beyond_rest;
    const std::string of = "triangles of " + muscle(pair.muscle);
    if (pair.kind == CrossedSurface::itself) {
      add({Requirement::self_passage, value, allowed, of + " through the muscle itself"});
    } else if (pair.kind == CrossedSurface::muscle) {
      if (!m_rest.touch(pair.muscle, pair.other) || m_scene.wanted.nothing_passes) {
        add({Requirement::muscle_passage, value, allowed, of + " through " + muscle(pair.other)});
      }
    } else if (m_rest.bones[static_cast<std::size_t>(pair.other)].thickness_m == 0) {
      add({Requirement::bone_passage, value, allowed, of + " through " + bone(pair.other)});
    }
  }

  const Scene& m_scene;
  const StepRecord& m_frame;
  const MuscleAtRest& m_rest;
  std::vector<RequiredFigure> m_figures;
};

bool is_same(const RigidMotion& one, const RigidMotion& other) {
  constexpr double rounding = 1e-9;
  return (one.rotation - other.rotation).norm() < rounding &&
         (one.translation_m - other.translation_m).norm() < rounding;
}

/// Whether the shape at the end can be compared with that at the start.
bool comes_back(const Scene& scene) {
  std::vector<RigidMotion> first;
  std::vector<RigidMotion> last;
  scene.poses_at(0, first);
  scene.poses_at(scene.loop.frames, last);
  if (!std::ranges::equal(first, last, is_same)) return false;
  return asks_for(scene.wanted, Requirement::returned_shape) || std::ranges::any_of(scene.motions, &BoneMotion::turns);
}

void add_slack(const Scene& scene, const RunResult& run, std::vector<RequiredFigure>& figures) {
  if (!scene.wanted.moment_arm_m) return;
  RequiredFigure worst{Requirement::taut_fibres, 0, least_slack};
  const ArmCourse course = arm_course(run.fibres);
  if (course.mean_lengths_m.empty()) worst.value = std::numeric_limits<double>::infinity();
  for (std::size_t muscle = 0; muscle < course.mean_lengths_m.size() && !pulls_fibres(scene); ++muscle) {
    const std::vector<double>& lengths_m = course.mean_lengths_m[muscle];
    for (std::size_t frame = 1; frame < lengths_m.size(); ++frame) {
      const double slack = 1 - lengths_m[frame] / lengths_m.front();
      if (slack <= worst.value || std::isinf(worst.value)) continue;
      worst.value = std::isnan(slack) ? std::numeric_limits<double>::infinity() : slack;
      worst.where = scene.muscles[muscle].body.name;
      worst.when = {run.fibres[frame].frame, run.fibres[frame].angle_rad * degrees_per_radian};
    }
  }
  figures.push_back(std::move(worst));
}

}  // namespace

double RequiredFigure::excess() const { return limit > 0 ? value / limit : 1 + value; }

std::string RequiredFigure::value_text() const {
  switch (requirement) {
    case Requirement::whole_surface:
      return std::isinf(value) ? "a run that diverges" : fmt::format("{:.3g} times", value);
    case Requirement::volume:
    case Requirement::taut_fibres:
      return in_percent(value);
    case Requirement::bone_passage:
    case Requirement::muscle_passage:
    case Requirement::self_passage:
      return fmt::format("{:g}", value);
    case Requirement::bone_depth:
    case Requirement::muscle_depth:
    case Requirement::returned_shape:
      return in_millimetres(value);
    case Requirement::trusted_run:
      if (holds()) return "a run that is ok";
      return where.starts_with("diverges") ? "a run that diverges" : "a suspect run";
  }
  return {};
}

std::string RequiredFigure::text() const {
  RequiredFigure at_limit = *this;
  at_limit.value = limit;
  const std::string moment = when.frame == 0 ? ""
                             : when.angle_deg == 0
                                 ? fmt::format("frame {}; ", when.frame)
                                 : fmt::format("at {:.0f} degrees, frame {}; ", when.angle_deg, when.frame);
  const std::string wanted = fmt::format(" ({}wanted {})", moment, at_limit.value_text());
  switch (requirement) {
    case Requirement::whole_surface:
      if (std::isinf(value)) return "the run diverges";
      return fmt::format("one edge of a hundred is {} as long as at rest, or longer ({}limit {})", value_text(), moment,
                         at_limit.value_text());
    case Requirement::volume:
      if (where.empty()) return "a volume is wanted and can't be judged: no muscle has a closed surface";
      if (std::isinf(value)) return where + " is turned inside out";
      return fmt::format("the volume of {} is off by {}{}", where, value_text(), wanted);
    case Requirement::taut_fibres:
      if (std::isinf(value)) return "moment arms cannot be told: no fibres are followed";
      return fmt::format("the fibres of {} are {} shorter than at rest, and nothing pulls on them{}", where,
                         value_text(), wanted);
    case Requirement::bone_passage:
    case Requirement::muscle_passage:
    case Requirement::self_passage:
      return fmt::format("{} {}{}", value_text(), value == 1 ? of_one(where) : where, wanted);
    case Requirement::bone_depth:
    case Requirement::muscle_depth:
      return fmt::format("{} {} {} deep{}{}", where, is_bound ? "may be" : "is", value_text(), wanted,
                         is_bound ? "; the Referee's budget did not suffice: more substeps pay for it" : "");
    case Requirement::trusted_run:
      return "the run " + where;
    case Requirement::returned_shape:
      if (where.empty()) return "a return is wanted and can't be judged: bones do not come back";
      return fmt::format("{} ends {} (RMS) from where it began{}", where, value_text(), wanted);
  }
  return {};
}

std::vector<RequiredFigure> figures_of_frame(const Scene& scene, const StepRecord& frame, const MuscleAtRest& rest) {
  return FrameFigures(scene, frame, rest).take();
}

std::vector<RequiredFigure> figures_of_run(const Scene& scene, const RunResult& run) {
  std::vector<RequiredFigure> figures;
  for (const StepRecord& frame : run.records) {
    for (RequiredFigure& figure : figures_of_frame(scene, frame, run.rest)) keep_worse(figures, std::move(figure));
  }
  if (run.status == "diverged") {
    const StepRecord& last = run.records.back();
    keep_worse(figures, {Requirement::whole_surface,
                         std::numeric_limits<double>::infinity(),
                         outcome_limit("edge_stretch_p99"),
                         "",
                         {last.frame, last.angle_deg}});
  }
  if (run.outcome.max_volume_error) {
    const bool is_inverted = run.outcome.turned_inside_out.value_or(false);
    figures.push_back(
        {Requirement::volume, is_inverted ? std::numeric_limits<double>::infinity() : *run.outcome.max_volume_error,
         scene.wanted.volume_share, scene.muscles[static_cast<std::size_t>(run.outcome.volume_muscle)].body.name,
         run.outcome.when_volume});
  }
  constexpr double unknown = std::numeric_limits<double>::infinity();
  if (!run.outcome.max_volume_error && asks_for(scene.wanted, Requirement::volume)) {
    figures.push_back({Requirement::volume, unknown, scene.wanted.volume_share});
  }
  if (!comes_back(scene) && asks_for(scene.wanted, Requirement::returned_shape)) {
    figures.push_back({Requirement::returned_shape, unknown, scene.wanted.returned_m});
  }
  if (!run.end_positions.empty() && comes_back(scene)) {
    const LargestDistance moved = largest_rms_distance(scene.bodies(), run.start_positions, run.end_positions);
    figures.push_back({Requirement::returned_shape,
                       moved.distance_m,
                       scene.wanted.returned_m,
                       scene.muscles[moved.body].body.name,
                       {scene.loop.frames, 0}});
  }
  add_slack(scene, run, figures);
  const std::string why = run.status == "diverged"  ? "diverges: " + run.status_detail
                          : run.status == "suspect" ? "is suspect: " + run.status_detail
                                                    : "is ok";
  figures.push_back({Requirement::trusted_run, why == "is ok" ? 0.0 : 1.0, 0, why});
  std::ranges::sort(figures, {}, &RequiredFigure::requirement);
  return figures;
}

void note_unmet_wants(const RunCase& run, RunResult& result) {
  const bool is_over = result.status == "ok" || result.status == "suspect";
  if (!run.judge || !is_over || run.scene.wanted.own_values.empty()) return;
  for (const RequiredFigure& figure : figures_of_run(run.scene, result)) {
    if (figure.holds() || !asks_for(run.scene.wanted, figure.requirement)) continue;
    result.status = "suspect";
    result.status_detail += (result.status_detail.empty() ? "" : "; ") + figure.text();
  }
}

const RequiredFigure* find_figure(std::span<const RequiredFigure> figures, Requirement requirement) {
  const auto found = std::ranges::find(figures, requirement, &RequiredFigure::requirement);
  return found == figures.end() ? nullptr : &*found;
}

LargestDistance largest_rms_distance(std::span<const Body> bodies, std::span<const Vec3> from,
                                     std::span<const Vec3> to) {
  LargestDistance largest;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    double squares_m2 = 0;
    for (int node = bodies[i].first_node; node < bodies[i].last_node; ++node) {
      squares_m2 += (to[static_cast<std::size_t>(node)] - from[static_cast<std::size_t>(node)]).squaredNorm();
    }
    const double distance_m = std::sqrt(squares_m2 / (bodies[i].last_node - bodies[i].first_node));
    if (distance_m > largest.distance_m) largest = {i, distance_m};
  }
  return largest;
}

}  // namespace musclebench

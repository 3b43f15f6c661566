#include "core/measure/outcome.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/base/percentile.hpp"

namespace musclebench {
namespace {

std::optional<double> p99_of(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return percentile(values, 0.99);
}

std::optional<double> largest_of(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return *std::max_element(values.begin(), values.end());
}

/// Whether it was raised.
bool raise(std::optional<double>& largest, double value) {
  if (!std::isfinite(value) || (largest && value <= *largest)) return false;
  largest = value;
  return true;
}

bool raise(std::optional<int>& largest, std::optional<int> value) {
  if (!value || (largest && *value <= *largest)) return false;
  largest = value;
  return true;
}

Moment moment_of(const StepRecord& record) { return {record.frame, record.angle_deg}; }

/// Takes the depth where it is a larger part of its limit than the worst so far.
void raise(std::optional<WorstDepth>& worst, WorstDepth depth) {
  if (!(depth.depth_m > 0)) return;
  if (!worst || depth.depth_m * worst->limit.depth_m > worst->depth_m * depth.limit.depth_m) worst = std::move(depth);
}

bool is_known(const DeepBodies& bodies, std::size_t muscles, std::size_t others) {
  return bodies.muscle >= 0 && bodies.other >= 0 && bodies.muscle < static_cast<int>(muscles) &&
         bodies.other < static_cast<int>(others);
}

void add_worst_depths(const StepRecord& record, const MuscleAtRest& rest, Outcome& outcome) {
  const auto muscle = [&](int index) -> const MuscleSize& { return rest.muscles[static_cast<std::size_t>(index)]; };
  const auto in_bone = [&](double depth_m, const DeepBodies& bodies, bool is_bone_vertex) {
    if (!is_known(bodies, rest.muscles.size(), rest.bones.size())) return;
    const DepthLimit limit = depth_limit(muscle(bodies.muscle), rest.bones[static_cast<std::size_t>(bodies.other)]);
    raise(outcome.worst_depth, {depth_m, limit, bodies, moment_of(record), is_bone_vertex, record.depth.max_depth_m});
  };
  in_bone(record.surface_depth_m, record.surface_bodies, false);
  in_bone(record.bone_vertex_depth_m, record.bone_vertex_bodies, true);
  in_bone(record.thin_bone_depth_m, record.thin_bone_bodies, record.thin_bone_is_vertex);
  const auto in_muscle = [&](double depth_m, const DeepBodies& bodies) {
    if (!is_known(bodies, rest.muscles.size(), rest.muscles.size())) return;
    const DepthLimit limit = depth_limit(muscle(bodies.muscle), muscle(bodies.other));
    raise(outcome.worst_muscle_depth,
          {depth_m, limit, bodies, moment_of(record), false, record.in_muscles ? record.in_muscles->max_depth_m : 0});
  };
  in_muscle(record.muscle_surface_depth_m, record.muscle_surface_bodies);
  if (record.in_muscles) in_muscle(record.in_muscles->max_depth_m, record.in_muscles_bodies);
}

/// Of the muscle `index`; an error of another that is larger stays.
void add_volumes(std::span<const StepRecord> records, const MuscleAtRest& rest, std::size_t index, Outcome& outcome) {
  const double target_m3 = rest.pressure * rest.volumes_m3[index];
  double last_error = std::abs(1 - 1 / rest.pressure);
  bool approaching = true;
  std::optional<double> final_error;
  for (const StepRecord& record : records) {
    const double volume_m3 = record.volumes_m3[index];
    const double error = std::abs((volume_m3 - target_m3) / target_m3);
    final_error.reset();
    if (!std::isfinite(error)) continue;
    final_error = error;
    outcome.turned_inside_out = outcome.turned_inside_out.value_or(false) || volume_m3 / target_m3 < 0;
    approaching = approaching && error < last_error;
    last_error = error;
    if (!approaching && raise(outcome.max_volume_error, error)) {
      outcome.when_volume = moment_of(record);
      outcome.volume_muscle = static_cast<int>(index);
    }
  }
  if (final_error) {
    raise(outcome.final_volume_error, *final_error);
    if (raise(outcome.max_volume_error, *final_error)) {
      outcome.when_volume = moment_of(records.back());
      outcome.volume_muscle = static_cast<int>(index);
    }
  }
}

void raise(std::vector<MostCrossings>& most, std::span<const int> counts, const StepRecord& record) {
  most.resize(std::max(most.size(), counts.size()));
  for (std::size_t pair = 0; pair < counts.size(); ++pair) {
    if (counts[pair] > most[pair].triangles) most[pair] = {counts[pair], record.frame, record.angle_deg};
  }
}

void add_crossings(const StepRecord& record, Outcome& outcome) {
  raise(outcome.self_intersecting_triangles, record.self_intersecting_triangles);
  raise(outcome.bone_crossings, record.bone_crossings);
  raise(outcome.muscle_crossings, record.muscle_crossings);
  outcome.crossing_frames += record.crossings.empty() ? 0 : 1;
  raise(outcome.crossings, record.crossings, record);
  raise(outcome.beyond_rest, record.beyond_rest, record);
}

void add_crossings_at_rest(const MuscleAtRest& rest, Outcome& outcome) {
  if (rest.crossings.empty()) return;
  const CrossingSums sums = sums_of(rest.crossing_pairs, rest.crossings);
  outcome.bone_crossings_at_rest = sums.in_bones;
  outcome.muscle_crossings_at_rest = sums.in_muscles;
  outcome.self_intersecting_triangles_at_rest = sums.in_itself;
}

}  // namespace

Outcome outcome_of(std::span<const StepRecord> records, const MuscleAtRest& rest) {
  Outcome outcome;
  std::vector<double> depths;
  std::vector<double> surface_depths;
  for (const StepRecord& record : records) {
    outcome.collision_ns += record.times.collision_ns();
    outcome.loop_ns += record.times.frame_ns;
    if (raise(outcome.max_edge_stretch, record.edge_stretch.max)) outcome.when_max_stretch = moment_of(record);
    if (raise(outcome.p99_edge_stretch, record.edge_stretch.p99)) outcome.when_p99_stretch = moment_of(record);
    add_crossings(record, outcome);
    outcome.nodes_inside_at_end.reset();
    if (!record.judged) continue;
    outcome.nodes_inside_at_end = record.depth.nodes_inside;
    depths.push_back(record.depth.max_depth_m);
    const double surface_depth = std::max(record.surface_depth_m, record.bone_vertex_depth_m);
    if (std::isfinite(surface_depth)) surface_depths.push_back(surface_depth);
    raise(outcome.max_surface_depth_bound_m, record.surface_depth_bound_m);
    raise(outcome.max_surface_depth_bound_m, record.bone_vertex_depth_bound_m);
    outcome.open_judgements += record.judgement_complete ? 0 : 1;
    if (record.in_muscles) {
      raise(outcome.max_muscle_depth_m, record.in_muscles->max_depth_m);
      raise(outcome.nodes_inside_muscles, record.in_muscles->nodes_inside);
    }
    if (raise(outcome.tunnelled_nodes, record.tunnelled_nodes)) outcome.when_tunnelled = moment_of(record);
    if (raise(outcome.stuck_nodes, record.stuck_nodes)) outcome.when_stuck = moment_of(record);
    raise(outcome.max_muscle_surface_depth_m, record.muscle_surface_depth_m);
    if (raise(outcome.passed_nodes, record.passed_nodes)) outcome.when_passed = moment_of(record);
    if (record.ring_escape.share > outcome.ring_escape.share) {
      outcome.ring_escape = record.ring_escape;
      outcome.when_out_of_ring = moment_of(record);
    }
    add_worst_depths(record, rest, outcome);
    outcome.true_contacts = outcome.true_contacts.value_or(0) + record.true_contacts;
    outcome.missed_beyond = outcome.missed_beyond.value_or(0) + record.missed_beyond;
    outcome.max_missed_m = std::max(outcome.max_missed_m, record.max_missed_m);
  }
  outcome.max_depth_m = largest_of(depths);
  outcome.p99_depth_m = p99_of(depths);
  outcome.max_surface_depth_m = largest_of(surface_depths);
  outcome.p99_surface_depth_m = p99_of(surface_depths);
  if (rest.depth) {
    outcome.nodes_inside_at_rest = rest.depth->nodes_inside;
    outcome.depth_at_rest_m = rest.depth->max_depth_m;
  }
  if (rest.in_muscles) {
    outcome.muscle_depth_at_rest_m = rest.in_muscles->max_depth_m;
  }
  add_crossings_at_rest(rest, outcome);
  for (std::size_t muscle = 0; muscle < rest.volumes_m3.size(); ++muscle) {
    if (muscle < rest.are_open.size() && rest.are_open[muscle]) continue;
    add_volumes(records, rest, muscle, outcome);
  }
  return outcome;
}

bool MuscleAtRest::touch(int one, int other) const {
  return std::ranges::find(touching, std::pair(std::min(one, other), std::max(one, other))) != touching.end();
}

}  // namespace musclebench

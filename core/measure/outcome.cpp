#include "core/measure/outcome.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace musclebench {
namespace {

/// The 99th percentile by nearest rank.
std::optional<double> p99_of(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  return values[(99 * values.size() + 99) / 100 - 1];
}

std::optional<double> largest_of(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return *std::max_element(values.begin(), values.end());
}

}  // namespace

Outcome outcome_of(std::span<const StepRecord> records, double rest_volume_m3) {
  Outcome outcome;
  std::vector<double> depths;
  std::vector<double> surface_depths;
  std::vector<double> volume_errors;
  for (const StepRecord& record : records) {
    outcome.collision_ns += record.times.update_ns + record.times.detect_ns + record.times.respond_ns;
    outcome.loop_ns += record.times.frame_ns;
    const double volume_error = std::abs((record.volume_m3 - rest_volume_m3) / rest_volume_m3);
    outcome.final_volume_error.reset();
    if (std::isfinite(volume_error)) {
      volume_errors.push_back(volume_error);
      outcome.final_volume_error = volume_error;
    }
    if (!record.judged) continue;
    depths.push_back(record.depth.max_depth_m);
    const double surface_depth = std::max(record.surface_depth_m, record.bone_vertex_depth_m);
    if (std::isfinite(surface_depth)) surface_depths.push_back(surface_depth);
    outcome.tunnelled_nodes = std::max(outcome.tunnelled_nodes.value_or(0), record.tunnelled_nodes);
    outcome.stuck_nodes = std::max(outcome.stuck_nodes.value_or(0), record.stuck_nodes);
  }
  outcome.max_depth_m = largest_of(depths);
  outcome.p99_depth_m = p99_of(depths);
  outcome.max_surface_depth_m = largest_of(surface_depths);
  outcome.p99_surface_depth_m = p99_of(surface_depths);
  outcome.max_volume_error = largest_of(volume_errors);
  return outcome;
}

}  // namespace musclebench

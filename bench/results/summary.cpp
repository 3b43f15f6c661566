#include "bench/results/summary.hpp"

#include <utility>

#include <fmt/format.h>

#include "bench/results/fibre_output.hpp"
#include "bench/results/force_output.hpp"
#include "core/base/percentile.hpp"

namespace musclebench {

namespace {

double megabytes(std::size_t bytes) { return static_cast<double>(bytes) * 1e-6; }

std::string median_frame_ms(const std::vector<StepRecord>& records, Nanoseconds (*figure)(const StepRecord&)) {
  std::vector<Nanoseconds> values;
  for (const StepRecord& record : records) {
    if (!record.warm_up) {
      values.push_back(figure(record));
    }
  }
  return median_ms(std::move(values));
}

std::string attachments_of(const RunCase& run, const RunResult& result) {
  std::string text;
  for (const Attachment& attachment : run.scene.attachments) {
    text += fmt::format("  attachment {:<18} {:>6} nodes on {}\n", attachment.name, attachment.nodes.size(),
                        run.scene.bones[attachment.bone].name);
  }
  if (run.scene.attach_at_first_contact) {
    text += fmt::format("  bound at first contact        {:>6} nodes\n", result.bound_nodes.size());
  }
  return text;
}

std::string source_of(const SceneSource& source) {
  if (source.licence.empty()) return {};
  std::string text = fmt::format("  licence of the shapes         {}{}\n", source.licence,
                                 source.is_non_commercial ? ": not for commercial use" : "");
  for (const std::string& citation : source.citations)
    text += fmt::format("  cite                          {}\n", citation);
  return text;
}

std::string times_of(const RunResult& result) {
  const std::string collision_ms = median_frame_ms(
      result.records, [](const StepRecord& r) { return r.times.update_ns + r.times.detect_ns + r.times.respond_ns; });
  const std::string frame_ms = median_frame_ms(result.records, [](const StepRecord& r) { return r.times.frame_ns; });
  std::string text = fmt::format("  frames                        {:>6}\n", result.records.size());
  text += fmt::format("  frame, median                 {}\n", frame_ms);
  text += fmt::format("  of it collision               {}\n", collision_ms);
  if (result.machine.switches.involuntary > 0) {
    text += fmt::format("  disturbed                     {:>6} times by other processes\n",
                        result.machine.switches.involuntary);
  }
  for (std::size_t i = 0; i < result.stage_names.size(); ++i) {
    std::vector<Nanoseconds> times;
    for (const StepRecord& record : result.records) {
      if (!record.warm_up) times.push_back(record.times.stages_ns[i]);
    }
    text += fmt::format("  of it {:<24}{}\n", result.stage_names[i], median_ms(std::move(times)));
  }
  return text;
}

std::string structures_of(const RunResult& result) {
  std::string text = fmt::format("  structures                    {:>10.3f} MB, built in {:.2f} s\n",
                                 megabytes(result.structure_bytes), static_cast<double>(result.build_ns) * 1e-9);
  for (const StructureError& error : result.structure_errors) {
    text += fmt::format("    {:<24} {:>10.3f} MB, off by {:.4f} mm (99 % of {} samples near it), at most {:.4f} mm\n",
                        error.bone, megabytes(error.bytes), error.p99_m * 1e3, error.samples, error.largest_m * 1e3);
  }
  return text;
}

std::string depths_of(const Outcome& outcome) {
  std::string text = fmt::format("  largest true depth            {:>10.3f} mm, of the surface {:.3f} mm",
                                 *outcome.max_depth_m * 1e3, outcome.max_surface_depth_m.value_or(0) * 1e3);
  if (outcome.open_judgements > 0) {
    text += fmt::format(" or more, at most {:.3f} mm ({} frames were judged in part)",
                        outcome.max_surface_depth_bound_m.value_or(0) * 1e3, outcome.open_judgements);
  }
  text += "\n";
  text += fmt::format("  nodes tunnelled, stuck        {:>6}, at most {} at once\n", *outcome.tunnelled_nodes,
                      *outcome.stuck_nodes);
  text += fmt::format("  free nodes inside             {:>6} at rest, {} at the end\n",
                      outcome.nodes_inside_at_rest.value_or(0),
                      outcome.nodes_inside_at_end ? fmt::format("{}", *outcome.nodes_inside_at_end) : "unknown");
  return text;
}

std::string between_muscles(const Outcome& outcome) {
  if (!outcome.max_muscle_depth_m) {
    return "";
  }
  return fmt::format("  deepest in another muscle     {:>10.3f} mm, {:.3f} mm at rest; {} nodes at most\n",
                     *outcome.max_muscle_depth_m * 1e3, outcome.muscle_depth_at_rest_m.value_or(0) * 1e3,
                     outcome.nodes_inside_muscles.value_or(0));
}

std::string shape_of(const Outcome& outcome) {
  std::string text = between_muscles(outcome);
  if (outcome.max_volume_error) {
    text += fmt::format("  volume off its target         {:>10.3f} %{}\n", *outcome.max_volume_error * 100,
                        outcome.turned_inside_out.value_or(false) ? ", turned inside out" : "");
  }
  if (outcome.max_edge_stretch) {
    text += fmt::format("  edge over its length at rest  {:>10.3f} at most, 99 % up to {:.3f}\n",
                        *outcome.max_edge_stretch, outcome.p99_edge_stretch.value_or(0));
  }
  if (outcome.self_intersecting_triangles) {
    text += fmt::format("  triangles through their own   {:>6} at most, {} at rest\n",
                        *outcome.self_intersecting_triangles, outcome.self_intersecting_triangles_at_rest.value_or(0));
  }
  if (outcome.bone_crossings) {
    text += fmt::format("  triangles through bones       {:>6} at most, {} at rest\n", *outcome.bone_crossings,
                        outcome.bone_crossings_at_rest.value_or(0));
  }
  if (outcome.muscle_crossings) {
    text += fmt::format("  triangles through muscles     {:>6} at most, {} at rest\n", *outcome.muscle_crossings,
                        outcome.muscle_crossings_at_rest.value_or(0));
  }
  return text;
}

std::string millimetres(const ProbeRow& row, double error_m) {
  return row.measured_points > 0 ? fmt::format("{:.6f}", error_m * 1e3) : "-";
}

}  // namespace

std::string median_ms(std::vector<Nanoseconds> values) {
  if (values.empty()) {
    return "unknown (warm-up only)";
  }
  return fmt::format("{:10.3f} ms", median(std::move(values)) * 1e-6);
}

std::string run_summary(const RunCase& run, const RunResult& result) {
  std::string text = fmt::format("{} with {}: {}{}{}\n", run.scene.name, run.backend.name, result.status,
                                 result.status_detail.empty() ? "" : ": ", result.status_detail);
  for (const std::string& note : result.notes) text += fmt::format("  note: {}\n", note);
  text += attachments_of(run, result) + times_of(result) + structures_of(result);
  text +=
      result.outcome.max_depth_m ? depths_of(result.outcome) : "  depths                        unknown (not judged)\n";
  return text + shape_of(result.outcome) + force_summary(result) + fibre_summary(run, result) +
         fmt::format("  state hash                    {}\n", result.state_hash) + source_of(run.scene.source);
}

std::string probe_summary(const ProbeCase& what, const ProbeResult& result) {
  std::string text = fmt::format("{} with {}: {}\n", what.scene.name, what.backend.name, result.status);
  text += fmt::format("  {:<14} {:<6} {:>8} {:>12} {:>12} {:>12} {:>12} {:>13}\n", "bone", "region", "points",
                      "largest mm", "99th mm", "mean mm", "rms mm", "wrong side");
  for (const ProbeRow& row : result.rows) {
    const ErrorStatistics& errors = row.errors_m;
    const std::string wrong =
        row.points > 0 ? fmt::format("{:.3f} %", 100 * static_cast<double>(row.wrong_side) / row.points) : "-";
    text += fmt::format("  {:<14} {:<6} {:>8} {:>12} {:>12} {:>12} {:>12} {:>13}\n", row.bone, row.region, row.points,
                        millimetres(row, errors.max), millimetres(row, errors.p99), millimetres(row, errors.mean),
                        millimetres(row, errors.rms), wrong);
  }
  return text + fmt::format("  structures {:.3f} MB, built in {:.2f} s\n", megabytes(result.structure_bytes),
                            static_cast<double>(result.build_ns) * 1e-9);
}

}  // namespace musclebench

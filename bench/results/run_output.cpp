#include "bench/results/run_output.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "bench/results/fibre_output.hpp"
#include "bench/results/findings_json.hpp"
#include "bench/results/force_output.hpp"
#include "bench/results/manifest.hpp"
#include "bench/results/result_folder.hpp"
#include "core/base/output_file.hpp"
#include "core/measure/muscle_record.hpp"
#include "core/measure/outcome_limits.hpp"
#include "core/measure/pair_record.hpp"
#include "core/mesh_files/read_mesh.hpp"

namespace musclebench {

namespace {

namespace fs = std::filesystem;

template <typename Value>
Json json_of(const std::optional<Value>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json json_of_run(const RunCase& run) {
  Json json = json_of_case(run, "coupled");
  json["warm_up_frames"] = run.warm_up_frames;
  json["judged"] = run.judge;
  json["snapshots"] = run.snapshots;
  json["self_intersections"] = run.count_self_intersections;
  json["pruning"] = run.prune;
  if (run.scene.fibre_count > 0) json["fibres"] = run.scene.fibre_count;
  if (run.forces) json["forces"] = true;
  for (const auto& [key, value] : run.scene.wanted.own_values)
    std::visit([&, &name = key](const auto& held) { json["wanted"][name] = held; }, value);
  return json;
}

Json json_of_attachments(const RunCase& run, const RunResult& result) {
  Json attachments = Json::array();
  for (const Attachment& attachment : run.scene.attachments) {
    attachments.push_back({{"name", attachment.name},
                           {"bone", run.scene.bones[attachment.bone].name},
                           {"nodes", attachment.nodes.size()}});
  }
  if (run.scene.attach_at_first_contact) {
    for (std::size_t bone = 0; bone < run.scene.bones.size(); ++bone) {
      const auto nodes = std::count_if(result.bound_nodes.begin(), result.bound_nodes.end(),
                                       [&](const BoundNode& n) { return n.bone == static_cast<int>(bone); });
      attachments.push_back({{"name", "first_contact"}, {"bone", run.scene.bones[bone].name}, {"nodes", nodes}});
    }
  }
  return attachments;
}

std::string snapshot_file(const Snapshot& snapshot) { return fmt::format("snapshots/frame_{:04}.ply", snapshot.frame); }

Json json_of_snapshots(const RunResult& result) {
  Json snapshots = Json::array();
  for (const Snapshot& snapshot : result.snapshots) {
    Json poses = Json::array();
    for (const RigidMotion& pose : snapshot.bone_poses) {
      Json rotation = Json::array();
      for (int i = 0; i < 9; ++i) {
        rotation.push_back(pose.rotation(i / 3, i % 3));
      }
      poses.push_back({{"rotation", rotation},
                       {"translation_m", {pose.translation_m.x(), pose.translation_m.y(), pose.translation_m.z()}}});
    }
    snapshots.push_back({{"frame", snapshot.frame},
                         {"angle_deg", snapshot.angle_deg},
                         {"file", snapshot_file(snapshot)},
                         {"bone_poses", poses}});
    if (!snapshot.surface_depths_m.empty()) {
      snapshots.back()["surface_depth_complete"] = snapshot.surface_is_complete;
    }
    if (!snapshot.fibres.empty()) snapshots.back()["fibres"] = fibre_file(snapshot);
    if (!snapshot.contact.pressures_pa.empty()) snapshots.back()["bone_pressure"] = bone_pressure_file(snapshot);
  }
  return snapshots;
}

Json json_of_structure_errors(const RunResult& result) {
  Json errors = Json::array();
  for (const StructureError& error : result.structure_errors) {
    errors.push_back({{"bone", error.bone},
                      {"bytes", error.bytes},
                      {"samples", error.samples},
                      {"p99_m", error.p99_m},
                      {"largest_m", error.largest_m}});
  }
  return errors;
}

Json json_of_outcome(const RunResult& result) {
  const Outcome& outcome = result.outcome;
  return {{"max_depth_m", json_of(outcome.max_depth_m)},
          {"p99_depth_m", json_of(outcome.p99_depth_m)},
          {"p99_contact_depth_m", json_of(outcome.p99_contact_depth_m)},
          {"max_surface_depth_m", json_of(outcome.max_surface_depth_m)},
          {"p99_surface_depth_m", json_of(outcome.p99_surface_depth_m)},
          {"max_surface_depth_bound_m", json_of(outcome.max_surface_depth_bound_m)},
          {"max_volume_error", json_of(outcome.max_volume_error)},
          {"final_volume_error", json_of(outcome.final_volume_error)},
          {"turned_inside_out", json_of(outcome.turned_inside_out)},
          {"max_edge_stretch", json_of(outcome.max_edge_stretch)},
          {"p99_edge_stretch", json_of(outcome.p99_edge_stretch)},
          {"tunnelled_nodes", json_of(outcome.tunnelled_nodes)},
          {"stuck_nodes", json_of(outcome.stuck_nodes)},
          {"nodes_inside_at_end", json_of(outcome.nodes_inside_at_end)},
          {"nodes_inside_at_rest", json_of(outcome.nodes_inside_at_rest)},
          {"depth_at_rest_m", json_of(outcome.depth_at_rest_m)},
          {"max_muscle_depth_m", json_of(outcome.max_muscle_depth_m)},
          {"muscle_depth_at_rest_m", json_of(outcome.muscle_depth_at_rest_m)},
          {"max_muscle_surface_depth_m", json_of(outcome.max_muscle_surface_depth_m)},
          {"passed_nodes", json_of(outcome.passed_nodes)},
          {"max_ring_escape_m", outcome.ring_escape.outside_m},
          {"true_contacts", json_of(outcome.true_contacts)},
          {"missed_beyond_bound", json_of(outcome.missed_beyond)},
          {"max_missed_m", outcome.max_missed_m},
          {"nodes_inside_muscles", json_of(outcome.nodes_inside_muscles)},
          {"self_intersecting_triangles", json_of(outcome.self_intersecting_triangles)},
          {"self_intersecting_triangles_at_rest", json_of(outcome.self_intersecting_triangles_at_rest)},
          {"bone_crossing_triangles", json_of(outcome.bone_crossings)},
          {"bone_crossing_triangles_at_rest", json_of(outcome.bone_crossings_at_rest)},
          {"muscle_crossing_triangles", json_of(outcome.muscle_crossings)},
          {"muscle_crossing_triangles_at_rest", json_of(outcome.muscle_crossings_at_rest)},
          {"crossing_frames", outcome.crossing_frames},
          {"open_judgements", outcome.open_judgements},
          {"collision_ns", outcome.collision_ns},
          {"loop_ns", outcome.loop_ns}};
}

Json json_of_crossings(const Scene& scene, const RunResult& result) {
  Json list = Json::array();
  for (std::size_t i = 0; i < result.rest.crossing_pairs.size(); ++i) {
    const CrossingPair& pair = result.rest.crossing_pairs[i];
    const auto other = static_cast<std::size_t>(pair.other);
    Json one = {{"muscle", scene.muscles[static_cast<std::size_t>(pair.muscle)].body.name}};
    if (pair.kind == CrossedSurface::bone) one["bone"] = scene.bones[other].name;
    if (pair.kind != CrossedSurface::bone) one["other_muscle"] = scene.muscles[other].body.name;
    one["at_rest"] = result.rest.crossings[i];
    const bool tested = i < result.outcome.crossings.size();
    one["most"] = tested ? Json(result.outcome.crossings[i].triangles) : Json(nullptr);
    one["frame"] = tested ? Json(result.outcome.crossings[i].frame) : Json(nullptr);
    one["beyond_rest"] = tested ? Json(result.outcome.beyond_rest[i].triangles) : Json(nullptr);
    one["left_out"] = pair.left_out;
    list.push_back(one);
  }
  return list;
}

Json json_of_limits() {
  Json limits = Json::object();
  for (const OutcomeLimit& limit : outcome_limits()) limits[std::string(limit.info.name)] = limit.limit;
  return limits;
}

Json manifest(const RunCase& run, const RunResult& result) {
  Json json = manifest_head(result.status, result.status_detail, json_of_run(run), run);
  json["muscle"]["rest_volume_m3"] = sum_of(result.rest.volumes_m3);
  json["muscle"]["pressure"] = result.rest.pressure;
  json["muscle"]["mean_edge_length_m"] = result.rest.mean_edge_length_m;
  json["muscle"]["free_nodes"] = result.rest.free_nodes;
  json["warnings"] = json_of(run.scene.warnings);
  if (run.scene.auto_effects.wanted) json["added_effects"] = json_of_added(run.scene);
  json["notes"] = result.notes;
  json["machine_state"] = json_of(result.machine);
  json["attachments"] = json_of_attachments(run, result);
  json["bound_nodes"] = result.bound_nodes.size();
  json["structure_bytes"] = result.structure_bytes;
  json["muscle_structure_bytes"] = result.muscle_structure_bytes;
  json["face_structure_bytes"] = result.face_structure_bytes;
  json["face_build_ns"] = result.face_build_ns;
  json["pruned"] = json_of(result.pruned, run.scene);
  json["structure_errors"] = json_of_structure_errors(result);
  add_origin(json, result.structures);
  json["build_ns"] = result.build_ns;
  json["cpu_ns"] = {{"before_first_frame", result.cpu_before_ns}, {"after_last_frame", result.cpu_after_ns}};
  json["memory"] = {{"before_first_frame_bytes", result.memory_before_bytes},
                    {"after_last_frame_bytes", result.memory_after_bytes},
                    {"peak_bytes", result.memory_peak_bytes},
                    {"referee_bytes", result.referee_bytes},
                    {"huge_page_bytes", result.huge_page_bytes}};
  json["state_hash"] = result.state_hash;
  json["wall_ns"] = result.wall_ns;
  json["frames"] = result.records.size();
  json["outcome"] = json_of_outcome(result);
  json["crossings"] = json_of_crossings(run.scene, result);
  json["limits"] = json_of_limits();
  json["snapshots"] = json_of_snapshots(result);
  if (run.forces) json["forces"] = json_of_forces(result);
  for (const auto& [stage, frame, why] : result.gave_up) {
    json["gave_up"].push_back({{"stage", stage}, {"frame", frame}, {"why", why}});
  }
  if (!result.fibres_refused.empty()) json["fibres_refused"] = result.fibres_refused;
  if (!result.followed_fibres.empty()) {
    json["fibres"] = json_of_fibres(result);
    json["memory"]["fibre_bytes"] = result.fibre_bytes;
  }
  return json;
}

template <typename Value>
void put(std::string& bytes, Value value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// What the muscles' files hold, one after the other: their vertices, in their order.
struct MuscleFiles {
  TriangleMesh mesh;
  std::vector<int> node_of_vertex;
};

MuscleFiles files_of(const Scene& scene) {
  MuscleFiles files;
  for (const Muscle& muscle : scene.muscles) {
    const auto first = static_cast<int>(files.mesh.vertices.size());
    const TriangleMesh& mesh = muscle.file.mesh;
    files.mesh.vertices.insert(files.mesh.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    files.node_of_vertex.insert(files.node_of_vertex.end(), muscle.node_of_vertex.begin(), muscle.node_of_vertex.end());
    for (const auto& [a, b, c] : mesh.triangles) {
      files.mesh.triangles.push_back({first + a, first + b, first + c});
    }
  }
  return files;
}

void write_snapshot(const fs::path& path, const Snapshot& snapshot, const RunCase& run,
                    const std::vector<BoundNode>& bound_nodes) {
  std::vector<unsigned char> attached(snapshot.positions.size(), 0);
  for (const BoundNode& bound : bound_nodes) {
    attached[bound.node] = 1;
  }
  const MuscleFiles files = files_of(run.scene);
  // Absent where nobody judged: a reader would take zeros for truth.
  const bool has_depths = !snapshot.depths_m.empty();
  const bool has_surface_depths = !snapshot.surface_depths_m.empty();
  const bool has_forces = !snapshot.contact.pressures_pa.empty();
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double "
      "z\n{}{}{}property uchar attached\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      files.mesh.vertices.size(), has_depths ? "property double depth_m\n" : "",
      has_surface_depths ? "property double surface_depth_m\n" : "",
      has_forces ? "property double pressure_pa\nproperty double force_x_n\nproperty double force_y_n\nproperty double "
                   "force_z_n\n"
                 : "",
      files.mesh.triangles.size());
  for (std::size_t i = 0; i < files.mesh.vertices.size(); ++i) {
    const int node = files.node_of_vertex[i];
    const Vec3& position = node < 0 ? files.mesh.vertices[i] : snapshot.positions[node];
    for (int axis = 0; axis < 3; ++axis) {
      put(bytes, position[axis]);
    }
    if (has_depths) put(bytes, node < 0 ? 0.0 : snapshot.depths_m[node]);
    if (has_surface_depths) put(bytes, node < 0 ? 0.0 : snapshot.surface_depths_m[node]);
    if (has_forces) {
      put(bytes, node < 0 ? 0.0 : snapshot.contact.pressures_pa[node]);
      for (int axis = 0; axis < 3; ++axis) put(bytes, node < 0 ? 0.0 : snapshot.contact.forces_n[node][axis]);
    }
    put(bytes, node < 0 ? static_cast<unsigned char>(0) : attached[node]);
  }
  for (const Triangle& triangle : files.mesh.triangles) {
    put(bytes, static_cast<unsigned char>(3));
    for (const int corner : triangle) {
      put(bytes, corner);
    }
  }
  OutputFile file(path);
  file.stream() << bytes;
  file.close();
}

void write_files(const fs::path& folder, const RunCase& run, const RunResult& result) {
  OutputFile frames(folder / "frames.csv");
  write_frames_csv(frames.stream(), result.effect_names, result.stage_names, result.records);
  frames.close();
  if (run.scene.muscles.size() > 1) {
    std::vector<std::string> names;
    for (const Body& body : run.scene.bodies()) names.push_back(body.name);
    OutputFile muscles(folder / "muscles.csv");
    write_muscles_csv(muscles.stream(), names, result.records);
    muscles.close();
    OutputFile pairs(folder / "pairs.csv");
    write_pairs_csv(pairs.stream(), result.records);
    pairs.close();
  }
  if (!result.snapshots.empty()) {
    fs::create_directory(folder / "snapshots");
    fs::create_directory(folder / "meshes");
    for (const Snapshot& snapshot : result.snapshots) {
      write_snapshot(folder / snapshot_file(snapshot), snapshot, run, result.bound_nodes);
    }
    for (const Bone& bone : run.scene.bones) {
      write_ply(bone.surface.mesh, folder / "meshes" / (bone.name + ".ply"));
    }
  }
  if (!result.followed_fibres.empty()) write_fibres(folder, run, result);
  if (run.forces) write_forces(folder, result);
  if (run.scene.auto_effects.wanted) {
    OutputFile scene(folder / "resolved_scene.toml");
    scene.stream() << run.scene.auto_effects.resolved_text;
    scene.close();
  }
  OutputFile json(folder / "run.json");
  json.stream() << text_of(manifest(run, result), 2) << '\n';
  json.close();
}

}  // namespace

std::string run_id(const RunCase& run) { return id_of(json_of_run(run), run.scene); }

void write_run(const fs::path& folder, const RunCase& run, const RunResult& result) {
  write_result_folder(folder, [&](const fs::path& part) { write_files(part, run, result); });
}

}  // namespace musclebench

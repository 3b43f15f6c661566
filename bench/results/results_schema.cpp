#include "bench/results/results_schema.hpp"

#include <array>
#include <deque>
#include <string>
#include <vector>

#include "bench/results/probe_output.hpp"
#include "bench/results/replay_output.hpp"
#include "core/measure/fibre_record.hpp"
#include "core/measure/force_record.hpp"
#include "core/measure/muscle_record.hpp"
#include "core/measure/outcome_limits.hpp"
#include "core/measure/pair_record.hpp"
#include "core/measure/step_record.hpp"

namespace musclebench {
namespace {

constexpr ManifestKey everywhere(std::string_view name, std::string_view unit, std::string_view help) {
  return {{name, unit, help}, true, true, true};
}
constexpr ManifestKey of_run(std::string_view name, std::string_view unit, std::string_view help) {
  return {{name, unit, help}, true, false, false};
}
constexpr ManifestKey of_replay(std::string_view name, std::string_view unit, std::string_view help) {
  return {{name, unit, help}, false, true, false};
}
constexpr ManifestKey of_probe(std::string_view name, std::string_view unit, std::string_view help) {
  return {{name, unit, help}, false, false, true};
}
constexpr ManifestKey of_run_and_replay(std::string_view name, std::string_view unit, std::string_view help) {
  return {{name, unit, help}, true, true, false};
}

constexpr auto own_keys = std::to_array<ManifestKey>({
    everywhere("schema_version", "", "version of columns and keys"),
    everywhere("status", "",
               "ok, suspect (an outcome is beyond its limit, or an answer off by more than is declared), diverged, "
               "interrupted, nondeterministic, unsupported"),
    everywhere("status_detail", "", "why it is not ok"),
    everywhere("run_id", "", "hash of the resolved case, the inputs and the build"),
    everywhere("title", "", "of the scene"),
    everywhere("source.licence", "", "of the scene's shapes, where the scene says it"),
    everywhere("source.cite[]", "", "publications to cite"),
    everywhere("source.url", "", "where they are published"),
    everywhere("source.non_commercial", "", "whether the licence forbids commercial use"),
    everywhere("case.mode", "", "coupled, replay or probe"),
    everywhere("case.scene", "", "name of the scene"),
    everywhere("case.preset", "", "where loop and effects come from"),
    everywhere("case.backend", "", "name of the backend"),
    everywhere("implementations.*", "", "by backend of the case: whose code it is"),
    everywhere("case.response", "", "what moves colliding nodes; by_bone: see case.bone_responses"),
    everywhere("case.response_steps", "", "detections of projecting, and corrections between muscles, at most"),
    everywhere("case.parameters.*", "", "of the backend, as resolved"),
    everywhere("case.threads", "", "asked of the backend"),
    everywhere("case.repetition", "", "number of the repetition"),
    everywhere("case.attachment", "", "areas or first_contact"),
    everywhere("case.effects.*.*", "", "parameters of each effect"),
    everywhere("case.loop.*", "", "parameters of the loop"),
    everywhere("case.meshes.*", "", "how often triangles were split in four"),
    of_run("case.wanted.*", "", "what the scene or the command line asks of the run, where it does"),
    of_run("case.face_contact.backend", "", "that answers for faces, where it is not the exact distance"),
    of_run("case.face_contact.parameters.*", "", "of it, as resolved"),
    everywhere("case.muscle_contact[].muscles[]", "", "two that touch each other"),
    everywhere("case.muscle_contact[].backend", "", "that detects it"),
    everywhere("case.muscle_contact[].parameters.*", "", "of it, as resolved"),
    everywhere("case.muscle_contact[].steps", "", "of corrections between the two"),
    everywhere("case.bone_backends.*.backend", "",
               "of each bone that has one of its own; MUSCLE/BONE where muscles differ"),
    everywhere("case.bone_backends.*.parameters.*", "", "of it, as resolved"),
    everywhere("case.bone_responses.*.response", "",
               "what moves nodes in that bone, where bones differ; MUSCLE/BONE where muscles do"),
    everywhere("case.bone_responses.*.steps", "", "detections of projecting out of it, at most"),
    of_run_and_replay("case.warm_up_frames", "", "frames that medians leave out"),
    of_run_and_replay("case.judged", "", "whether the Referee looked on"),
    of_run("case.snapshots[]", "", "frames whose shape was kept"),
    of_run("case.self_intersections", "", "whether self-intersecting triangles were counted"),
    of_run("case.pruning", "", "whether bones that muscles are not expected to touch were left out at first"),
    of_run("case.fibres", "", "of each muscle, asked for; absent where none are"),
    of_run("case.forces", "", "true where forces are told; absent elsewhere"),
    of_replay("case.stride", "", "every so many-th frame is replayed"),
    of_replay("case.band_m", "m", "errors are measured so far from the surface"),
    of_replay("case.recording_sha256", "", "of the recording"),
    of_probe("case.points", "", "asked about each bone"),
    of_probe("case.seed", "", "of the points"),
    of_probe("case.band_m", "m", "how far from the surface the points lie at most"),
    everywhere("muscle.name", "", "of the muscle"),
    everywhere("muscle.mesh", "", "file or embedded mesh"),
    everywhere("muscle.vertices", "", "of the mesh as read and split"),
    everywhere("muscle.triangles", "", "of the mesh as read and split"),
    everywhere("muscle.mesh_sha256", "", "of its coordinates and indices, as read"),
    everywhere("muscle.nodes", "", "vertices after equal positions were joined and unused ones left out"),
    everywhere("muscle.repairs[]", "", "what was mended, in words"),
    of_run("muscle.rest_volume_m3", "m3", "volume at rest, V0"),
    of_run("muscle.pressure", "", "target volume over that at rest, p; 1 without the effect volume"),
    of_run("muscle.mean_edge_length_m", "m", "at rest"),
    of_run("muscle.free_nodes", "", "that no bone carries"),
    everywhere("muscles[].name", "", "of each of several muscles; `muscle` has their sums"),
    everywhere("muscles[].mesh", "", "file or embedded mesh"),
    everywhere("muscles[].vertices", "", "of the mesh as read and split"),
    everywhere("muscles[].triangles", "", "of the mesh as read and split"),
    everywhere("muscles[].mesh_sha256", "", "of its coordinates and indices, as read"),
    everywhere("muscles[].nodes", "", "after equal positions were joined and unused vertices left out"),
    everywhere("muscles[].repairs[]", "", "what was mended, in words"),
    everywhere("bones[].name", "", "of the bone"),
    everywhere("bones[].mesh", "", "file or embedded mesh"),
    everywhere("bones[].vertices", "", "of the mesh as read"),
    everywhere("bones[].triangles", "", "of the mesh as read"),
    everywhere("bones[].mesh_sha256", "", "of its coordinates and indices, as read"),
    everywhere("bones[].repairs[]", "", "what was mended, in words"),
    everywhere("bones[].motion.axis[]", "", "unit vector"),
    everywhere("bones[].motion.centre_m[]", "m", "a point of the axis"),
    everywhere("bones[].motion.times[]", "", "of the table of angles"),
    everywhere("bones[].motion.angles_rad[]", "rad", "about the axis"),
    everywhere("bones[].motion.there_and_back", "", "whether the motion returns"),
    everywhere("build.version", "", "of the program"),
    everywhere("build.git", "", "git describe of its source"),
    everywhere("build.compiler", "", "name and version"),
    everywhere("build.flags", "", "of the compiler"),
    everywhere("build.type", "", "CMake's build type"),
    everywhere("machine.cpu", "", "model name"),
    everywhere("machine.cores", "", "that are online"),
    everywhere("machine.governor", "", "of the first core's frequency"),
    everywhere("machine.clock_resolution_ns", "ns", "of the clock that times"),
    of_run("notes[]", "", "what a reader should know beside status_detail, in sentences"),
    of_run("warnings[].rule", "", "what is odd about the scene: id of the rule that found it"),
    of_run("warnings[].text", "", "in one line"),
    of_run("added_effects[].effect", "", "what `effects = \"auto\"` added: an effect, or contact of two muscles"),
    of_run("added_effects[].rule", "", "id of the checker's rule that asked for it"),
    of_run("added_effects[].reason", "", "what it found"),
    of_run_and_replay("machine_state.involuntary_context_switches", "",
                      "times that the scheduler gave the CPU to others within the timed regions"),
    of_run_and_replay("machine_state.voluntary_context_switches", "", "times that the process waited in them"),
    of_run_and_replay("machine_state.load_average_1m.before", "", "processes that ran or wanted to, last minute"),
    of_run_and_replay("machine_state.load_average_1m.after", "", "the same after the last frame"),
    of_run_and_replay("machine_state.cpu_mhz.before", "MHz", "of the core before the first frame, where it is told"),
    of_run_and_replay("machine_state.cpu_mhz.after", "MHz", "of the core after the last frame"),
    of_run_and_replay("machine_state.governor", "", "of that core's frequency, where it is told"),
    of_run_and_replay("machine_state.allowed_cores", "", "that the process may run on; 1: it is pinned"),
    of_run_and_replay("machine_state.nice", "", "priority of the process; 0 is usual"),
    of_run_and_replay("machine_state.turbo", "", "whether clocks may rise above their base, where it is told"),
    of_run_and_replay("machine_state.smt", "", "whether two threads share a core, where it is told"),
    of_run("attachments[].name", "", "of the attachment"),
    of_run("attachments[].bone", "", "that carries its nodes"),
    of_run("attachments[].nodes", "", "bound"),
    of_run("bound_nodes", "", "of all attachments, each once"),
    everywhere("structure_bytes", "bytes", "of the backend's structures"),
    of_run_and_replay("muscle_structure_bytes", "bytes", "of what detects contacts between muscles"),
    of_run("face_structure_bytes", "bytes", "of what answers for faces, where it is not the exact distance"),
    of_run("face_build_ns", "ns", "to build that; of a bone that is met late it is within a frame, too"),
    of_replay("muscle_build_ns", "ns", "building it"),
    of_run_and_replay("pruned[].bone", "", "over which nothing, or a part only, was built before the first frame"),
    of_run_and_replay("pruned[].reason", "",
                      "out_of_reach: no muscle was expected near it in the whole motion; partly_out_of_reach: near a "
                      "part of its grid's cells only"),
    of_run_and_replay("pruned[].kept_share", "", "of the cells of its grid that were built at first"),
    of_run_and_replay("pruned[].distance_m", "m",
                      "between the boxes of bone and muscle where they were expected nearest"),
    of_run_and_replay("pruned[].margin_m", "m", "at least so much was asked of that"),
    of_run_and_replay("pruned[].watch_m", "m", "a node that comes so near the bone's box brings it back"),
    of_run_and_replay("pruned[].saved_triangles", "", "of the bone that are in no structure; 0 where it came back"),
    of_run_and_replay("pruned[].saved_queries", "", "nodes that the backend was not asked about"),
    of_run_and_replay("pruned[].is_back", "",
                      "whether a node came within reach all the same, so that what lacked was built"),
    of_run_and_replay("pruned[].frame_back", "", "of a run, in which a node came within reach; null: never"),
    of_run_and_replay("pruned[].build_ns", "ns", "building its structure then, a part of that frame's time"),
    of_run("structure_errors[].bone", "", "whose structure approximates"),
    of_run("structure_errors[].bytes", "bytes", "of that structure"),
    of_run("structure_errors[].samples", "", "points at which it was compared with the surface"),
    of_run("structure_errors[].p99_m", "m", "99th percentile of the error there"),
    of_run("structure_errors[].largest_m", "m", "largest error there"),
    everywhere("structures", "", "built, or loaded from a file"),
    everywhere("build_ns", "ns", "building or loading them"),
    everywhere("kept_build_ns", "ns", "of loaded ones: what building them took once, where that is noted beside them"),
    of_run("cpu_ns.before_first_frame", "ns", "CPU time of all threads: reading, checking, building"),
    of_run("cpu_ns.after_last_frame", "ns", "the same after the last frame"),
    of_run("memory.before_first_frame_bytes", "bytes", "resident, without the Referee and huge pages"),
    of_run("memory.after_last_frame_bytes", "bytes", "the same after the last frame"),
    of_run("memory.peak_bytes", "bytes", "of the whole process"),
    of_run("memory.referee_bytes", "bytes", "taken by what judges"),
    of_run("memory.huge_page_bytes", "bytes", "resident only because pages are large"),
    of_run("state_hash", "", "of all positions and velocities at the end"),
    of_run_and_replay("wall_ns", "ns", "from the first frame to the last, with judging"),
    of_run_and_replay("frames", "", "rows of frames.csv"),
    of_run("outcome.max_depth_m", "m", "largest true depth of a node"),
    of_run("outcome.p99_depth_m", "m", "99th percentile over the frames of their deepest node"),
    of_run("outcome.p99_contact_depth_m", "m",
           "99th percentile over all contacts of all frames of the node's depth at the frame's end"),
    of_run("outcome.max_surface_depth_m", "m",
           "largest depth of the surface in a bone or of a bone's vertex in the muscle"),
    of_run("outcome.p99_surface_depth_m", "m", "99th percentile of it over the frames"),
    of_run("outcome.max_surface_depth_bound_m", "m", "no such point is deeper in any frame"),
    of_run("outcome.max_volume_error", "", "largest |V - p V0| / |p V0|, without the approach to p V0 at the start"),
    of_run("outcome.final_volume_error", "", "the same after the last frame"),
    of_run("outcome.turned_inside_out", "", "whether the volume changed its sign"),
    of_run("outcome.max_edge_stretch", "", "largest edge length over length at rest"),
    of_run("outcome.p99_edge_stretch", "", "largest 99th percentile over the edges of a frame"),
    of_run("outcome.tunnelled_nodes", "", "most on the wrong side of a bone at the end of a frame"),
    of_run("outcome.stuck_nodes", "", "most held by false contacts in a frame"),
    of_run("outcome.nodes_inside_at_end", "", "free nodes in bones after the last frame"),
    of_run("outcome.nodes_inside_at_rest", "", "free nodes in bones before the first frame"),
    of_run("outcome.depth_at_rest_m", "m", "of the deepest of them"),
    of_run("outcome.max_muscle_depth_m", "m", "largest true depth of a node in another muscle, where muscles touch"),
    of_run("outcome.muscle_depth_at_rest_m", "m", "the same before the first frame"),
    of_run("outcome.max_muscle_surface_depth_m", "m", "largest depth of a point of the surface in another muscle"),
    of_run("outcome.passed_nodes", "", "most that went through another muscle between two judged frames"),
    of_run(
        "outcome.max_ring_escape_m", "m",
        "how far a tendon is out of its retinaculum, of that which is farthest out relative to its radius; 0: none is"),
    of_run("outcome.true_contacts", "", "in the last detections of all judged frames"),
    of_run("outcome.missed_beyond_bound", "", "of them missed and deeper than the backend declares that it may miss"),
    of_run("outcome.max_missed_m", "m", "depth of the deepest of these"),
    of_run("outcome.nodes_inside_muscles", "", "most nodes in other muscles after a frame"),
    of_run("outcome.self_intersecting_triangles", "", "most in a frame that was tested for crossings"),
    of_run("outcome.self_intersecting_triangles_at_rest", "", "before the first frame"),
    of_run("outcome.bone_crossing_triangles", "", "most that pass through bones in a frame that was tested"),
    of_run("outcome.bone_crossing_triangles_at_rest", "", "before the first frame"),
    of_run("outcome.muscle_crossing_triangles", "", "most that pass through other muscles; null with one muscle"),
    of_run("outcome.muscle_crossing_triangles_at_rest", "", "before the first frame"),
    of_run("outcome.crossing_frames", "",
           "judged frames that were tested for crossings: as often as the Referee's budget allows, kept frames and the "
           "last always"),
    of_run("outcome.open_judgements", "", "frames for which the Referee's budget did not suffice"),
    of_run("outcome.collision_ns", "ns", "of the backend with bones: update, detect and respond, sum over the run"),
    of_run("outcome.loop_ns", "ns", "sum of the frames"),
    of_run("crossings[].muscle", "", "whose triangles pass through"),
    of_run("crossings[].bone", "", "that bone"),
    of_run("crossings[].other_muscle", "", "or that muscle; the same one: itself"),
    of_run("crossings[].at_rest", "", "triangles that do before the first frame"),
    of_run("crossings[].most", "", "most in a frame that was tested; null: none was"),
    of_run("crossings[].frame", "", "the first with so many; 0: there were none"),
    of_run(
        "crossings[].beyond_rest", "",
        "most in a frame without those at rest and beside these: neither one at rest nor with a node of one, or more "
        "than these were"),
    of_run("crossings[].left_out", "",
           "triangles of the muscle that are not tested, as that bone carries one of their nodes, or bones carry all"),
    of_run("limits.*", "", "largest value with which a run is ok, see `list --json`"),
    of_run("snapshots[].frame", "", "whose shape was kept"),
    of_run("snapshots[].angle_deg", "deg", "of the bone that turns most"),
    of_run("snapshots[].file", "", "the shape"),
    of_run("snapshots[].surface_depth_complete", "",
           "false: its surface may be deeper in places, the budget was spent; absent where surface_depth_m is"),
    of_run("snapshots[].bone_pressure", "", "the pressed vertices of its bones, of a run with --forces"),
    of_run("snapshots[].fibres", "", "their fibres as lines, where they are followed"),
    of_run("forces.rows", "", "of forces.csv"),
    of_run("forces.joints[].bone", "", "that turns"),
    of_run("forces.joints[].min_torque_n_m", "N m", "least over the frames, of all muscles about its axis"),
    of_run("forces.joints[].max_torque_n_m", "N m", "largest over the frames"),
    of_run("forces.peak_pressure_pa", "Pa", "largest of a node in a frame; null: nothing touches"),
    of_run("forces.contacts_left_out", "", "why contacts have no forces; empty: they have"),
    of_run("forces.attachments_left_out", "", "why attachments have no forces; empty: they have"),
    of_run("fibres[].muscle", "", "whose fibres are followed"),
    of_run("fibres[].asked", "", "how many were asked for"),
    of_run("fibres[].followed", "", "how many reach from one attachment to the other"),
    of_run("gave_up[].stage", "", "an effect that could not hold what it promises"),
    of_run("gave_up[].frame", "", "in which that was first so"),
    of_run("gave_up[].why", "", "in words"),
    of_run("fibres_refused", "", "why none are followed where they were asked for if possible"),
    of_run("memory.fibre_bytes", "bytes", "of what binds fibres to the surface; a part of memory.referee_bytes"),
    of_run("snapshots[].bone_poses[].rotation[]", "", "by rows"),
    of_run("snapshots[].bone_poses[].translation_m[]", "m", "after the rotation"),
    of_replay("recording.file", "", "as it was named"),
    of_replay("recording.sha256", "", "of the file"),
    of_replay("recording.bytes", "bytes", "of the file"),
    of_replay("recording.frames", "", "recorded"),
    of_replay("recording.iterations", "", "collision steps recorded"),
    of_replay("recording.stride", "", "every so many-th frame is replayed"),
    of_replay("recording.backend", "", "that drove the recorded run"),
    of_replay("recording.build", "", "that recorded it"),
    of_replay("band_m", "m", "errors are measured, and offsets searched for, so far from the surface"),
    of_replay("contact_hash", "", "of all contacts with bones of all steps, in their order"),
    of_replay("queries_hash", "", "of all poses and positions that were asked about, in their order"),
    of_replay("declared.missed_depth_m", "m",
              "no deeper node may be missed, by the backend's word; null: it gives none"),
    of_replay("declared.false_distance_m", "m",
              "no node farther outside may be found, by its word; null: it gives none"),
    of_replay("muscle_contact_hash", "", "of all contacts between muscles, where they touch"),
    of_replay("accuracy_of_muscles[].muscle", "", "one of several, with all bones; the rest as in accuracy"),
    of_replay("muscle_accuracy[].muscles[]", "", "two that touch; the rest as in accuracy"),
    of_replay("surface_offset.of_pairs[].muscle", "", "with one bone"),
    of_replay("surface_offset.of_pairs[].bone", "", "the bone"),
    of_replay("surface_offset.of_difficulties[].difficulty", "", "what makes contact hard there"),
    of_probe("detect_ns", "ns", "of all points against all bones"),
    of_probe("probed[].name", "", "of the bone"),
    of_probe("probed[].cell_edge_m", "m", "smallest; null where the backend has no cells"),
    of_probe("probed[].sharp_radius_m", "m", "points so near to a sharp edge count as sharp"),
    of_probe("probed[].sharp_edges", "", "of the bone"),
    of_probe("probed[].sharp_vertices", "", "of the bone"),
});

/// Of the answers about contacts.
constexpr auto accuracy_keys = std::to_array<ColumnInfo>({
    {"contacts", "", "answered"},
    {"true_contacts", "", "by the Referee"},
    {"missed_contacts", "", "true ones that were not answered"},
    {"false_contacts", "", "answered ones that are not true"},
    {"measured_contacts", "", "both true and answered, with a depth, within the band"},
    {"max_depth_error_m", "m", "over the measured contacts"},
    {"p99_depth_error_m", "m", "over the measured contacts"},
    {"mean_depth_error_m", "m", "over the measured contacts"},
    {"max_normal_error_deg", "deg", "over those whose normal both sides know"},
    {"p99_normal_error_deg", "deg", "over those whose normal both sides know"},
    {"mean_normal_error_deg", "deg", "over those whose normal both sides know"},
    {"max_missed_depth_m", "m", "deepest contact that was missed"},
    {"max_false_distance_m", "m", "farthest contact that is false"},
});

/// Of where the backend's surface is.
constexpr auto offset_keys = std::to_array<ColumnInfo>({
    {"sites", "", "places of true contact that the backend was asked about"},
    {"open_sites", "", "those where its answer did not change within the band"},
    {"p99_offset_m", "m", "distance of its surface from the true one, in either direction, over the contacts"},
    {"max_offset_m", "m", "largest of it"},
    {"p99_inward_m", "m", "where its surface is too far in: nodes are let in so deep"},
    {"max_inward_m", "m", "largest of it"},
    {"p99_outward_m", "m", "where its surface is too far out: nodes are held off so far"},
    {"max_outward_m", "m", "largest of it"},
});

/// Keys of replays that stand in several places, with what stands before them there. Their names live as long as the
/// program.
void append_keys(std::span<const std::string_view> places, std::span<const ColumnInfo> infos,
                 std::vector<ManifestKey>& all) {
  static std::deque<std::string> names;
  for (const std::string_view place : places) {
    for (const ColumnInfo& info : infos) {
      names.push_back(std::string(place).append(".").append(info.name));
      all.push_back(of_replay(names.back(), info.unit, info.help));
    }
  }
}

std::vector<ManifestKey> all_keys() {
  std::vector<ManifestKey> all(own_keys.begin(), own_keys.end());
  append_keys(std::to_array<std::string_view>({"accuracy", "accuracy_of_muscles[]", "muscle_accuracy[]"}),
              accuracy_keys, all);
  append_keys(
      std::to_array<std::string_view>({"surface_offset", "surface_offset.of_pairs[]",
                                       "surface_offset.of_difficulties[]", "accuracy_of_muscles[].surface_offset"}),
      offset_keys, all);
  return all;
}

Json json_of(const ColumnInfo& info) { return {{"name", info.name}, {"unit", info.unit}, {"help", info.help}}; }

template <typename Columns>
Json json_of_columns(const Columns& columns) {
  Json list = Json::array();
  for (const auto& column : columns) list.push_back(json_of(column.info));
  return {{"columns", list}};
}

}  // namespace

std::string_view name_of(ResultKind kind) {
  constexpr std::string_view names[] = {"run", "replay", "probe"};
  return names[static_cast<int>(kind)];
}

bool ManifestKey::is_in(ResultKind kind) const {
  if (kind == ResultKind::run) return in_run;
  return kind == ResultKind::replay ? in_replay : in_probe;
}

std::span<const ManifestKey> manifest_keys() {
  static const std::vector<ManifestKey> keys = all_keys();
  return keys;
}

Json results_schema_json() {
  Json of_manifests = Json::object();
  for (const ResultKind kind : result_kinds) {
    Json list = Json::array();
    for (const ManifestKey& key : manifest_keys()) {
      if (key.is_in(kind)) list.push_back(json_of(key.info));
    }
    of_manifests[std::string(name_of(kind))] = list;
  }
  Json limits = Json::array();
  for (const OutcomeLimit& limit : outcome_limits()) {
    limits.push_back(json_of(limit.info));
    limits.back()["limit"] = limit.limit;
    limits.back()["why"] = limit.why;
  }
  return {{"results_schema", schema_version},
          {"run", json_of_columns(run_columns())},
          {"muscles", json_of_columns(muscle_columns())},
          {"pairs", json_of_columns(pair_columns())},
          {"forces", json_of_columns(force_columns())},
          {"bone_pressure", json_of_columns(bone_vertex_columns())},
          {"fibres", json_of_columns(fibre_columns())},
          {"fibre_lengths", json_of_columns(fibre_length_columns())},
          {"replay", json_of_columns(replay_columns())},
          {"replay_muscles", json_of_columns(replay_muscle_columns())},
          {"replay_pairs", json_of_columns(replay_pair_columns())},
          {"probe", json_of_columns(probe_columns())},
          {"run_json", of_manifests},
          {"limits", limits}};
}

}  // namespace musclebench

#include "bench/cases/run_case.hpp"

#include <algorithm>
#include <iterator>
#include <malloc.h>
#include <memory>

#include <fmt/ranges.h>

#include "bench/cases/build_backend.hpp"
#include "bench/cases/coupled_judge.hpp"
#include "bench/cases/divergence.hpp"
#include "bench/cases/kept_steps.hpp"
#include "core/base/huge_pages.hpp"
#include "core/base/input_error.hpp"
#include "core/base/sha256.hpp"
#include "core/base/system_memory.hpp"
#include "core/measure/crossings.hpp"
#include "core/measure/outcome_limits.hpp"
#include "core/pbd/muscle_contact_stage.hpp"
#include "core/scene/prepare_simulation.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

namespace {

std::string hash_of(const Simulation& simulation) {
  Sha256 hash;
  hash.add(std::as_bytes(std::span(simulation.positions())));
  hash.add(std::as_bytes(std::span<const Vec3>(simulation.velocities())));
  return hash.hex_digest().substr(0, 16);
}

/// What the Referee's trees over an anatomical muscle and its bones take; more comes in small pages at first.
constexpr std::size_t usual_referee_bytes = std::size_t{64} << 20U;

/// Drives one simulation and measures it between frames.
class CaseRunner {
 public:
  explicit CaseRunner(const RunCase& run) : m_run(run), m_scene(run.scene) {}

  RunResult run(const std::function<void(int)>& report, const std::function<void(double)>& report_build,
                const std::function<bool()>& is_stopped) {
    start(report_build);
    m_is_stopped = is_stopped;
    m_simulation->stop_when(is_stopped);
    const Nanoseconds start_ns = monotonic_now_ns();
    m_result.machine.before = machine_load();
    m_result.cpu_before_ns = process_cpu_ns();
    watch_fibres(0);
    keep_snapshot(0);
    for (int frame = 1; frame <= m_scene.loop.frames && m_result.status == "ok"; ++frame) {
      step(frame);
      if (m_result.status == "interrupted") break;
      report(frame);
      if (m_result.status == "ok" && m_run.has_seen_enough &&
          m_run.has_seen_enough(m_result.records.back(), m_result.rest)) {
        m_result.status = "interrupted";
        m_result.status_detail = fmt::format("in frame {} of {}, which showed enough", frame, m_scene.loop.frames);
      }
      if (m_result.status == "ok" && frame < m_scene.loop.frames && is_stopped && is_stopped()) {
        m_result.status = "interrupted";
        m_result.status_detail = fmt::format("after frame {} of {}", frame, m_scene.loop.frames);
      }
    }
    m_result.wall_ns = monotonic_now_ns() - start_ns;
    m_result.machine.after = machine_load();
    m_result.cpu_after_ns = process_cpu_ns();
    m_result.memory_after_bytes = memory_needed_bytes();
    m_result.memory_peak_bytes = peak_resident_memory_bytes();
    m_result.state_hash = hash_of(*m_simulation);
    if (m_result.status == "ok") m_result.end_positions = m_simulation->positions();
    conclude();
    return std::move(m_result);
  }

 private:
  void start(const std::function<void(double)>& report_build) {
    BuiltBackend built = build_backend(m_run, report_build);
    m_backend = std::move(built.backend);
    m_result.build_ns = built.build_ns;
    m_result.structure_bytes = m_backend->structure_bytes();
    m_result.structure_errors = m_backend->structure_errors();
    m_result.structures = m_backend->structure_origin();
    m_reach = std::move(built.reach);
    ContactMethods methods = make_contact_methods(m_scene, m_run.colliders, m_run.threads);
    for (const auto& detector : methods.muscle_detectors) {
      m_result.muscle_structure_bytes += detector->structure_bytes();
    }
    if (methods.make_surface_queries) {
      methods.make_surface_queries = [this, make = methods.make_surface_queries](const Bone& bone, int threads) {
        const Nanoseconds begun_ns = monotonic_now_ns();
        auto queries = make(bone, threads);
        m_result.face_build_ns += monotonic_now_ns() - begun_ns;
        m_result.face_structure_bytes += queries->bytes();
        return queries;
      };
    }

    PreparedSimulation prepared =
        prepare_simulation(m_run.scene, *m_backend, m_run.responses, m_run.threads, std::move(methods));
    if (!m_run.keeps_shared) release_shared(m_scene);
    m_simulation = std::move(prepared.simulation);
    note_pruned_bones(0);
    for (const auto& stage : m_simulation->stages()) {
      if (auto* found = dynamic_cast<MuscleContactStage*>(stage.get())) m_muscle_contact = found;
    }
    m_result.bound_nodes = std::move(prepared.bound_nodes);
    m_result.effect_names = std::move(prepared.effect_names);
    m_result.stage_names = std::move(prepared.stage_names);
    m_result.rest = muscle_at_rest();
    m_result.start_positions = m_simulation->positions();
    m_result.records.reserve(static_cast<std::size_t>(std::min(m_scene.loop.frames, 100000)));
    malloc_trim(0);  // what only the building needed shall not count as the structures' memory
    const std::size_t before_watching_bytes = resident_memory_bytes();
    make_room_for_snapshots();
    follow_fibres();
    if (m_run.forces) {
      m_result.force_obstacles = force_obstacles(m_scene, m_run.responses);
      m_forces = std::make_unique<ForceWatch>(m_scene, m_result.bound_nodes, m_result.force_obstacles, *m_simulation);
    }
    if (m_run.judge) {
      reserve_huge_pages(usual_referee_bytes);
      m_judge = std::make_unique<CoupledJudge>(
          m_scene, m_result.bound_nodes, *m_simulation, m_run.judges_wishes ? 1 : m_run.threads,
          [this](int bone) { return m_backend->answer_bound(bone).missed_depth_m; }, m_run.judging_effort);
      note_rest(m_judge->at_rest());
    }
    if (m_judge || m_fibres || m_forces || !m_room.empty()) {
      malloc_trim(0);
      m_result.referee_bytes = resident_memory_bytes() - std::min(resident_memory_bytes(), before_watching_bytes);
    }
    m_result.memory_before_bytes = memory_needed_bytes();
    const std::size_t before_bytes = resident_memory_bytes();
    move_to_huge_pages();
    m_result.huge_page_bytes = resident_memory_bytes() - std::min(resident_memory_bytes(), before_bytes);
  }

  void note_rest(const StepRecord& judged) {
    MuscleAtRest& rest = m_result.rest;
    rest.depth = judged.depth;
    rest.in_muscles = judged.in_muscles;
    rest.depth_bodies = judged.depth_bodies;
    rest.in_muscles_bodies = judged.in_muscles_bodies;
    rest.depths_in_muscles_m = judged.depths_in_muscles_m;
    const auto pairs = m_judge->crossing_pairs();
    rest.crossing_pairs.assign(pairs.begin(), pairs.end());
    rest.crossings = judged.crossings;
    rest.shared_faces = shared_faces(m_scene.muscle_mesh, m_scene.bodies());
    for (const Muscle& muscle : m_scene.muscles) {
      rest.muscles.push_back(size_of(muscle.body.name, m_scene.mesh_of(muscle.body)));
    }
    for (const Bone& bone : m_scene.bones) rest.bones.push_back({bone.name, thickness_m(bone.surface.mesh)});
    for (const SceneMusclePair& pair : m_scene.muscle_pairs) {
      rest.touching.push_back(std::minmax(pair.muscles.first, pair.muscles.second));
    }
    for (const SceneEffect& effect : m_scene.effects) rest.effects.push_back(effect.name);
    for (const Retinaculum& ring : m_scene.retinacula) rest.rings.push_back(ring.name);
    rest.backend = m_run.backend.name;
  }

  /// Before the first frame and written to, so that the memory of the run does not grow by them.
  void make_room_for_snapshots() {
    const std::size_t nodes = m_simulation->positions().size();
    const std::size_t judged_nodes = m_run.judge ? nodes : 0;
    for (std::size_t i = 0; i < m_run.snapshots.size(); ++i) {
      m_room.push_back({.positions = std::vector<Vec3>(nodes, Vec3::Zero()),
                        .depths_m = std::vector<double>(judged_nodes, 0.0),
                        .surface_depths_m = std::vector<double>(m_run.keep_surface_depths ? judged_nodes : 0, 0.0),
                        .bone_poses = {},
                        .fibres = {}});
    }
  }

  void follow_fibres() {
    m_result.fibres_refused = m_scene.fibres_refused;
    if (m_scene.fibre_count == 0) return;
    try {
      m_fibres = std::make_unique<FibreWatch>(m_scene, m_result.bound_nodes, m_run.threads);
    } catch (const InputError& refused) {
      if (m_scene.fibres_are_required) throw;
      m_result.fibres_refused = refused.what();
      return;
    }
    m_result.followed_fibres = m_fibres->followed();
    m_result.fibre_bytes = m_fibres->bytes();
  }

  /// Resident memory without the Referee and huge-page padding.
  [[nodiscard]] std::size_t memory_needed_bytes() const {
    const std::size_t resident_bytes = resident_memory_bytes();
    return resident_bytes - std::min(resident_bytes, m_result.referee_bytes + m_result.huge_page_bytes);
  }

  void step(int frame) {
    StepRecord record;
    record.frame = frame;
    record.angle_deg = m_scene.angle_rad(frame) * degrees_per_radian;
    record.warm_up = frame <= m_run.warm_up_frames;
    const ContextSwitches before = context_switches();
    const std::vector<int>& judged = m_run.judged_frames;
    const bool is_judged = m_judge && (judged.empty() || std::ranges::binary_search(judged, frame));
    record.times = m_simulation->step_frame(frame, is_judged ? &m_last_detection : nullptr);
    if (m_simulation->was_stopped()) {
      m_result.status = "interrupted";
      m_result.status_detail = fmt::format("in frame {} of {}, substep {} of {}", frame, m_scene.loop.frames,
                                           m_simulation->substep(), m_scene.loop.substeps);
      return;
    }
    const ContextSwitches switches = context_switches() - before;
    record.involuntary_switches = switches.involuntary;
    m_result.machine.switches += switches;
    note_pruned_bones(frame);
    note_what_gave_up(frame);
    record.contacts = static_cast<int>(m_simulation->contacts().size());
    if (m_muscle_contact != nullptr) record.muscle_contacts = m_muscle_contact->contact_count();
    if (m_scene.muscles.size() > 1) record.pairs = pairs_of(record.times);
    record.resident_bytes = memory_needed_bytes();

    const std::vector<Vec3>& positions = m_simulation->positions();
    record.volumes_m3 = volumes_m3(positions);
    record.muscles = muscles_of(record.volumes_m3);
    const std::string lost = describe_divergence(*m_simulation, frame);
    if (!lost.empty()) {
      m_result.status = "diverged";
      m_result.status_detail = lost + moved_out_by(frame);
    } else if (is_judged) {
      m_judge->judge(*m_simulation, m_last_detection, record,
                     is_looked_at(frame) || !judged.empty() || m_run.judges_wishes ? CrossingTest::always
                                                                                   : CrossingTest::where_budget_allows);
      note_crossings(record);
    } else if (m_judge) {
      m_judge->follow(*m_simulation, record);
    } else if (m_run.count_self_intersections && is_looked_at(frame)) {
      record.self_intersecting_triangles = count_self_crossings({positions, m_scene.muscle_mesh.triangles});
    }
    m_result.records.push_back(record);
    if (lost.empty()) {
      watch_fibres(frame);
      if (m_forces) std::ranges::move(m_forces->frame(frame, *m_simulation), std::back_inserter(m_result.forces));
      keep_snapshot(frame);
    }
  }

  /// In words that follow those of what was lost. The run is made again for it: the same bits, watched.
  [[nodiscard]] std::string moved_out_by(int frame) {
    PreparedSimulation again = prepare_simulation(m_scene, *m_backend, m_run.responses, m_run.threads,
                                                  make_contact_methods(m_scene, m_run.colliders, m_run.threads));
    KeptSteps steps(!m_scene.muscle_pairs.empty());
    again.simulation->stop_when(m_is_stopped);
    const std::string cause = cause_of_divergence(*again.simulation, frame, steps);
    m_result.last_steps = steps.take();
    return cause.empty() ? "" : ", moved out by " + cause;
  }

  void note_what_gave_up(int frame) {
    for (const auto& stage : m_simulation->stages()) {
      if (std::ranges::find(m_result.gave_up, stage->name(), &GaveUp::stage) != m_result.gave_up.end()) continue;
      std::string why = stage->gave_up();
      if (!why.empty()) m_result.gave_up.push_back({std::string(stage->name()), frame, std::move(why)});
    }
  }

  void note_pruned_bones(int frame) {
    std::vector<PrunedResult> pruned = pruned_results(*m_backend, m_reach);
    for (std::size_t i = 0; i < pruned.size(); ++i) {
      if (i < m_result.pruned.size()) pruned[i].frame_back = m_result.pruned[i].frame_back;
      if (!pruned[i].pruned.is_back || pruned[i].frame_back) continue;
      pruned[i].frame_back = frame;
      m_scene.bones[static_cast<std::size_t>(pruned[i].pruned.bone)].shared.release();
      m_result.structure_bytes = m_backend->structure_bytes();
      m_result.structure_errors = m_backend->structure_errors();
    }
    m_result.pruned = std::move(pruned);
  }

  /// What is known of each of several muscles without a judge.
  [[nodiscard]] std::vector<MuscleRecord> muscles_of(std::span<const double> volumes) const {
    std::vector<MuscleRecord> muscles(volumes.size() > 1 ? volumes.size() : 0);
    for (std::size_t i = 0; i < muscles.size(); ++i) {
      const Body& body = m_scene.muscles[i].body;
      muscles[i].volume_m3 = volumes[i];
      muscles[i].contacts = static_cast<int>(std::ranges::count_if(
          m_simulation->contacts(), [&](const Contact& contact) { return body.has_node(contact.node); }));
    }
    return muscles;
  }

  /// Bone after bone, each with all muscles; then muscles that touch.
  [[nodiscard]] std::vector<PairRecord> pairs_of(const StageTimes& times) const {
    const std::vector<Body> bodies = m_scene.bodies();
    std::vector<PairRecord> pairs;
    for (const Bone& bone : m_scene.bones) {
      for (const Muscle& muscle : m_scene.muscles) {
        const auto ns = times.pairs_ns.empty() ? std::nullopt : std::optional(times.pairs_ns[pairs.size()]);
        pairs.push_back({muscle.body.name, bone.name, ns, 0, {}});
      }
    }
    for (const Contact& contact : m_simulation->contacts()) {
      ++pairs[static_cast<std::size_t>(contact.bone) * bodies.size() + body_of(bodies, contact.node)].contacts;
    }
    if (m_muscle_contact != nullptr) append_touching_muscles(bodies, pairs);
    return pairs;
  }

  void append_touching_muscles(std::span<const Body> bodies, std::vector<PairRecord>& pairs) const {
    std::vector<MusclePair> touching;
    for (const PairTime& time : m_muscle_contact->take_pair_times()) {
      touching.push_back(time.muscles);
      pairs.push_back({bodies[static_cast<std::size_t>(time.muscles.first)].name,
                       bodies[static_cast<std::size_t>(time.muscles.second)].name,
                       time.detect_ns,
                       0,
                       {}});
    }
    const auto first = pairs.end() - static_cast<std::ptrdiff_t>(touching.size());
    for (const MuscleContact& contact : m_muscle_contact->contacts()) {
      const auto own = static_cast<int>(body_of(bodies, contact.node));
      const MusclePair pair{std::min(own, contact.muscle), std::max(own, contact.muscle)};
      ++first[std::ranges::find(touching, pair) - touching.begin()].contacts;
    }
  }

  /// Into the pairs of several muscles.
  void note_crossings(StepRecord& record) const {
    if (record.crossings.empty()) return;
    const std::vector<Body> bodies = m_scene.bodies();
    const auto name_of = [&](const CrossingPair& pair) {
      const auto other = static_cast<std::size_t>(pair.other);
      return pair.kind == CrossedSurface::bone ? m_scene.bones[other].name : bodies[other].name;
    };
    for (std::size_t i = 0; i < record.crossings.size(); ++i) {
      const CrossingPair& pair = m_result.rest.crossing_pairs[i];
      for (PairRecord& of_names : record.pairs) {
        if (of_names.muscle == bodies[static_cast<std::size_t>(pair.muscle)].name && of_names.other == name_of(pair)) {
          of_names.crossings = record.crossings[i];
        }
      }
    }
  }

  /// More closely than other frames.
  [[nodiscard]] bool is_looked_at(int frame) const { return is_kept(frame) || frame == m_scene.loop.frames; }

  [[nodiscard]] bool is_kept(int frame) const {
    return std::binary_search(m_run.snapshots.begin(), m_run.snapshots.end(), frame);
  }

  [[nodiscard]] std::vector<double> volumes_m3(std::span<const Vec3> positions) const {
    std::vector<double> volumes;
    for (const Muscle& muscle : m_scene.muscles) {
      volumes.push_back(body_volume_m3(positions, m_scene.muscle_mesh.triangles, muscle.body));
    }
    return volumes;
  }

  [[nodiscard]] MuscleAtRest muscle_at_rest() const {
    const TriangleMesh& mesh = m_scene.muscle_mesh;
    MuscleAtRest rest;
    rest.volumes_m3 = volumes_m3(mesh.vertices);
    for (std::size_t muscle = 0; muscle < m_scene.muscles.size(); ++muscle) {
      rest.are_open.push_back(!is_closed(m_scene.mesh_of(m_scene.muscles[muscle].body)));
    }
    rest.mean_edge_length_m = EdgeStretchMeter(mesh).mean_length_m();
    rest.free_nodes = static_cast<int>(m_simulation->free_nodes().size());
    rest.triangles = static_cast<int>(mesh.triangles.size());
    for (const SceneEffect& effect : m_scene.effects) {
      if (effect.name == "volume" || effect.name == "local_volume")
        rest.pressure = effect.parameters.number("pressure");
    }
    return rest;
  }

  void conclude() {
    m_result.outcome = outcome_of(m_result.records, m_result.rest);
    if (m_judge) m_result.outcome.p99_contact_depth_m = m_judge->contact_depths().percentile(0.99);
    if (m_run.count_self_intersections && !m_judge) {
      m_result.outcome.self_intersecting_triangles_at_rest = count_self_crossings(m_scene.muscle_mesh);
    }
    m_result.notes = outcome_notes(m_result.outcome);
    note_slack_fibres();
    if (!m_result.force_obstacles.unsettled.empty()) m_result.notes.push_back(m_result.force_obstacles.unsettled);
    std::vector<std::string> reasons = suspicions(m_result.outcome, m_result.rest);
    for (const auto& [stage, frame, why] : m_result.gave_up) {
      reasons.push_back(fmt::format("{} does not hold from frame {} on: {}", stage, frame, why));
    }
    if (m_scene.attach_at_first_contact && m_result.bound_nodes.empty()) {
      reasons.emplace_back("no node touches a bone at rest, and so none is bound (attachment = \"first_contact\")");
    }
    for (const SceneWarning& warning : m_scene.warnings) {
      // Bodies of two units meet nowhere, and an end that nothing holds swings free.
      if (warning.rule == "unit" || warning.rule == "empty_attachment" || warning.rule == "fibres_outside") {
        reasons.push_back(warning.text);
      }
    }
    if (m_result.status == "ok" && !reasons.empty()) {
      m_result.status = "suspect";
      m_result.status_detail = fmt::format("{}", fmt::join(reasons, "; "));
    }
  }

  void note_slack_fibres() {
    if (m_result.fibres.empty() || pulls_fibres(m_scene)) return;
    std::vector<std::string> names;
    for (const Muscle& muscle : m_scene.muscles) names.push_back(muscle.body.name);
    for (std::string& note : slack_notes(names, m_result.fibres)) m_result.notes.push_back(std::move(note));
  }

  void watch_fibres(int frame) {
    if (!m_fibres) return;
    m_fibre_points = m_fibres->points(m_simulation->positions());
    FibreFrame watched = m_fibres->frame(frame, m_scene.angle_rad(frame), m_fibre_points);
    for (std::size_t i = 0; m_judge && i < watched.muscles.size(); ++i) {
      watched.muscles[i].inside_share = m_judge->share_inside_bones(m_fibre_points[i], m_simulation->bone_poses());
    }
    m_result.fibres.push_back(std::move(watched));
  }

  void keep_snapshot(int frame) {
    if (!is_kept(frame)) {
      return;
    }
    Snapshot snapshot = std::move(m_room.back());
    m_room.pop_back();
    snapshot.frame = frame;
    snapshot.angle_deg = m_scene.angle_rad(frame) * degrees_per_radian;
    std::ranges::copy(m_simulation->positions(), snapshot.positions.begin());
    if (m_judge) {
      std::ranges::copy(m_judge->depths(*m_simulation), snapshot.depths_m.begin());
    }
    if (m_judge && m_run.keep_surface_depths) {
      const DepthsAroundNodes around = m_judge->surface_depths(*m_simulation);
      std::ranges::copy(around.depths_m, snapshot.surface_depths_m.begin());
      snapshot.surface_is_complete = around.complete;
    }
    const auto poses = m_simulation->bone_poses();
    snapshot.bone_poses.assign(poses.begin(), poses.end());
    if (m_fibres) snapshot.fibres = m_fibre_points;
    if (m_forces) {
      snapshot.contact = m_forces->at_nodes(*m_simulation);
      snapshot.on_bones = m_forces->on_bones(*m_simulation);
    }
    m_result.snapshots.push_back(std::move(snapshot));
  }

  const RunCase& m_run;
  const Scene& m_scene;
  RunResult m_result;
  std::vector<Snapshot> m_room;    ///< for those that are still to be kept
  std::vector<BoneReach> m_reach;  ///< by bone
  std::unique_ptr<CollisionBackend> m_backend;
  std::unique_ptr<Simulation> m_simulation;
  MuscleContactStage* m_muscle_contact = nullptr;  ///< of the simulation, where muscles touch
  std::unique_ptr<FibreWatch> m_fibres;            ///< where the scene asks for them
  std::vector<std::vector<Vec3>> m_fibre_points;   ///< of each muscle, at the end of the last frame
  std::unique_ptr<ForceWatch> m_forces;            ///< where they are asked for
  std::unique_ptr<CoupledJudge> m_judge;
  std::function<bool()> m_is_stopped;
  LastDetection m_last_detection;
};

}  // namespace

std::vector<SceneWarning> warnings_of_run(const RunCase& run) {
  std::vector<SceneWarning> warnings;
  for (std::string& line : effects_without_contacts(run.scene, run.backend, run.parameters, run.colliders)) {
    warnings.push_back({"no_contacts", std::move(line)});
  }
  if (!run.judge && !run.scene.wanted.own_values.empty()) {
    warnings.push_back({"wanted", "what is wanted is not looked at: the run is not judged"});
  }
  return warnings;
}

bool pulls_fibres(const Scene& scene) {
  return std::ranges::any_of(scene.effects, [](const SceneEffect& effect) {
    return effect.name == "activation" || (effect.name == "fibre_force" && effect.parameters.number("level") > 0);
  });
}

RunResult run_case(const RunCase& run, const std::function<void(int)>& report,
                   const std::function<void(double)>& report_build, const std::function<bool()>& is_stopped) {
  return CaseRunner(run).run(report, report_build, is_stopped);
}

}  // namespace musclebench

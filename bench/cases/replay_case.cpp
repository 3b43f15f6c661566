#include "bench/cases/replay_case.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bench/cases/answers_by_muscle.hpp"
#include "bench/cases/build_backend.hpp"
#include "bench/cases/replayed_frames.hpp"
#include "core/base/huge_pages.hpp"
#include "core/base/quantity_words.hpp"
#include "core/base/sha256.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

namespace {

static_assert(sizeof(Contact) == 40, "the hash of a contact may not contain padding");

void add_step(Sha256& hash, std::span<const Contact> contacts) {
  const std::size_t count = contacts.size();
  hash.add(std::as_bytes(std::span(&count, 1)));
  hash.add(std::as_bytes(contacts));
}

static_assert(sizeof(Vec3) == 24, "the hash of a position may not contain padding");
static_assert(sizeof(RigidMotion) == 96, "nor that of a pose");

void add_queries(Sha256& hash, const RecordedStep& step) {
  hash.add(std::as_bytes(std::span(step.bone_poses)));
  hash.add(std::as_bytes(std::span(step.positions)));
}

/// The largest of all bones.
AnswerBound declared_bound(const CollisionBackend& backend, int bones) {
  AnswerBound declared;
  for (int bone = 0; bone < bones; ++bone) {
    const AnswerBound bound = backend.answer_bound(bone);
    declared.missed_depth_m = std::max(declared.missed_depth_m, bound.missed_depth_m);
    declared.false_distance_m = std::max(declared.false_distance_m, bound.false_distance_m);
  }
  return declared;
}

class Replayer {
 public:
  Replayer(const ReplayCase& replay, FrameSource& recording, const std::function<void(int)>& report)
      : m_replay(replay), m_recording(recording), m_report(report), m_by_muscle(replay) {}

  ReplayResult run() {
    BuiltBackend built = build_backend(m_replay);
    release_shared(m_replay.scene);
    m_backend = std::move(built.backend);
    m_result.build_ns = built.build_ns;
    m_reach = std::move(built.reach);
    m_result.structures = m_backend->structure_origin();
    m_result.declared = declared_bound(*m_backend, static_cast<int>(m_replay.scene.bones.size()));
    move_to_huge_pages();

    const Nanoseconds start_ns = monotonic_now_ns();
    ask_twice();
    if (replays_muscles(m_replay, m_recording.header())) {
      m_result.muscles = replay_muscles(m_replay, m_recording, [&] { m_report(++m_frames_done); });
      if (!m_result.muscles->deterministic) {
        m_result.status = "nondeterministic";
        m_result.status_detail = "the two passes over the same input did not get the same contacts between muscles";
      }
    }
    m_result.wall_ns = monotonic_now_ns() - start_ns;
    return std::move(m_result);
  }

 private:
  void ask_twice() {
    m_result.machine.before = machine_load();
    m_result.contact_hash = timed_pass();
    m_result.machine.after = machine_load();
    m_result.pruned = pruned_results(*m_backend, m_reach);
    m_result.structure_bytes = m_backend->structure_bytes();  // with what came back
    if (m_replay.judge && judged_pass() != m_result.contact_hash) {
      m_result.status = "nondeterministic";
      m_result.status_detail = "the two passes over the same input did not get the same contacts";
    } else if (const std::string broken = broken_bound(); !broken.empty()) {
      m_result.status = "suspect";
      m_result.status_detail = broken;
    }
  }

  /// In words; empty where all answers are within what the backend declares, up to rounding.
  [[nodiscard]] std::string broken_bound() const {
    if (!m_result.accuracy) return "";
    const double rounding_m = 1e-9 * scene_diagonal_m(m_replay.scene);
    const Accuracy& found = *m_result.accuracy;
    std::vector<std::string> broken;
    if (found.max_missed_depth_m > m_result.declared.missed_depth_m + rounding_m) {
      broken.push_back(fmt::format("missed a contact {} deep, and declares none deeper than {}",
                                   in_millimetres(found.max_missed_depth_m),
                                   in_millimetres(m_result.declared.missed_depth_m)));
    }
    if (found.max_false_distance_m > m_result.declared.false_distance_m + rounding_m) {
      broken.push_back(fmt::format("found a contact {} outside, and declares none farther than {}",
                                   in_millimetres(found.max_false_distance_m),
                                   in_millimetres(m_result.declared.false_distance_m)));
    }
    if (broken.empty()) return "";
    return fmt::format("{} {}", m_replay.backend.name, fmt::join(broken, "; it "));
  }

  /// Calls `look` with every frame that is replayed. Backends with state between steps are first given the step before.
  template <typename Look>
  void for_each_frame(const Look& look) {
    const auto lead_in = [&](const RecordedStep& step) {
      m_backend->update(step.bone_poses, step.positions);
      if (m_backend->capabilities().has_cache) {
        m_backend->detect(step.positions, m_recording.header().free_nodes, m_unused);
      }
    };
    for_each_replayed_frame(m_recording, m_replay.stride, m_frame, lead_in, [&](const RecordedFrame& frame) {
      look(frame);
      m_report(++m_frames_done);
    });
  }

  std::string timed_pass() {
    Sha256 hash;
    Sha256 queries;
    Response response(m_replay.scene.responses(m_replay.responses), m_replay.scene.bodies());
    std::vector<std::vector<Contact>> answers;
    for_each_frame([&](const RecordedFrame& frame) {
      ReplayRecord record;
      record.frame = frame.frame;
      record.angle_deg = frame.angle_deg;
      record.warm_up = static_cast<int>(m_result.records.size()) < m_replay.warm_up_frames;
      record.iterations = static_cast<int>(frame.steps.size());
      m_by_muscle.prepare(record);
      answers.resize(frame.steps.size());
      const ContextSwitches before = context_switches();
      for (std::size_t i = 0; i < frame.steps.size(); ++i) {
        time_step(frame.steps[i], response, answers[i], record);
      }
      const ContextSwitches switches = context_switches() - before;
      record.involuntary_switches = switches.involuntary;
      m_result.machine.switches += switches;
      for (const std::vector<Contact>& answer : answers) {
        record.contacts += static_cast<long>(answer.size());
        m_by_muscle.add_contacts(answer, record);
        add_step(hash, answer);
      }
      for (const RecordedStep& step : frame.steps) add_queries(queries, step);
      m_result.records.push_back(std::move(record));
    });
    m_result.queries_hash = queries.hex_digest().substr(0, 16);
    return hash.hex_digest().substr(0, 16);
  }

  void time_step(const RecordedStep& step, Response& response, std::vector<Contact>& contacts, ReplayRecord& record) {
    // The response changes them, and the loop that it stands for has just written them: they are in the cache there,
    // too.
    m_positions = step.positions;
    {
      const ScopedTimer timer(record.update_ns);
      m_backend->update(step.bone_poses, m_positions);
    }
    {
      const ScopedTimer timer(record.detect_ns);
      m_backend->detect(m_positions, m_recording.header().free_nodes, contacts);
    }
    AnswersByMuscle::add_times(m_backend->pair_times(), record);
    const ScopedTimer timer(record.respond_ns);
    response.resolve(*m_backend, {step.substep_start, step.previous_bone_poses, step.bone_poses}, contacts,
                     m_positions);
  }

  std::string judged_pass() {
    const RecordingHeader& header = m_recording.header();
    Referee referee(m_replay.scene.bones, header.nodes, m_replay.threads);
    const bool depths_known = m_backend->capabilities().depth;
    Sha256 hash;
    std::vector<AnswerErrors> all(m_by_muscle.parts());
    std::vector<Contact> contacts;
    std::vector<Contact> truth;
    ContactSiteSampler sampler(m_replay.scene.bones.size(), m_replay.scene.bodies());
    auto record = m_result.records.begin();
    for_each_frame([&](const RecordedFrame& frame) {
      std::vector<AnswerErrors> errors(m_by_muscle.parts());
      for (const RecordedStep& step : frame.steps) {
        m_backend->update(step.bone_poses, step.positions);
        m_backend->detect(step.positions, header.free_nodes, contacts);
        add_step(hash, contacts);
        referee.judge(step.bone_poses, step.positions, header.free_nodes, truth);
        m_by_muscle.measure(referee, {step.bone_poses, step.positions, contacts, depths_known}, truth, m_replay.band_m,
                            errors);
      }
      if (!frame.steps.empty()) sampler.add(frame.steps.back().bone_poses, frame.steps.back().positions, truth);
      m_by_muscle.add_accuracy(errors, *record++);
      for (std::size_t part = 0; part < all.size(); ++part) all[part].add(errors[part]);
    });
    ReplayRecord whole;
    m_by_muscle.prepare(whole);
    m_by_muscle.add_accuracy(all, whole);
    m_result.accuracy = whole.accuracy;
    for (const MuscleAnswers& muscle : whole.muscles) m_result.accuracy_of_muscles.push_back(*muscle.accuracy);
    m_result.offsets = measure_surface(referee, sampler.sites());
    return hash.hex_digest().substr(0, 16);
  }

  [[nodiscard]] std::optional<SurfaceOffsets> measure_surface(const Referee& referee,
                                                              std::vector<ContactSite> sites) const {
    if (!m_backend->capabilities().point_queries) return std::nullopt;
    const Scene& scene = m_replay.scene;
    std::vector<double> diagonals_m;
    for (const Bone& bone : scene.bones) {
      diagonals_m.push_back(bounding_box(bone.surface.mesh.vertices).diagonal().norm());
    }
    classify_sites(referee, diagonals_m, scene.muscle_mesh, m_recording.header().free_nodes, sites);
    const AskInside ask = ask_backend(*m_backend, scene.bones.size(), 100 * scene_diagonal_m(scene), sites);
    return offset_statistics(sites, measure_offsets(ask, referee, diagonals_m, sites, m_replay.band_m),
                             scene.bones.size(), scene.muscles.size());
  }

  const ReplayCase& m_replay;
  FrameSource& m_recording;
  const std::function<void(int)>& m_report;
  AnswersByMuscle m_by_muscle;
  ReplayResult m_result;
  std::unique_ptr<CollisionBackend> m_backend;
  std::vector<BoneReach> m_reach;  ///< by bone
  RecordedFrame m_frame;
  std::vector<Vec3> m_positions;
  std::vector<Contact> m_unused;
  int m_frames_done = 0;
};

}  // namespace

int replayed_frames(const ReplayCase& replay, const RecordingHeader& header) {
  const int frames = header.frames() / replay.stride + (header.frames() % replay.stride != 0 ? 1 : 0);
  return frames * (replay.judge ? 2 : 1) * (replays_muscles(replay, header) ? 2 : 1);
}

bool replays_muscles(const ReplayCase& replay, const RecordingHeader& header) {
  return header.muscle_contact && !replay.colliders.of_muscle_pairs.empty();
}

ReplayResult replay_case(const ReplayCase& replay, FrameSource& recording, const std::function<void(int)>& report) {
  return Replayer(replay, recording, report).run();
}

}  // namespace musclebench

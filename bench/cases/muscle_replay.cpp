#include "bench/cases/muscle_replay.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "bench/cases/coupled_judge.hpp"
#include "bench/cases/replay_case.hpp"
#include "bench/cases/replayed_frames.hpp"
#include "core/base/sha256.hpp"
#include "core/referee/muscle_referee.hpp"

namespace musclebench {

namespace {

static_assert(sizeof(std::array<Vec3, 2>) == 2 * 3 * sizeof(double), "the hash of a contact may not contain padding");

/// Field by field: the struct has padding.
void add_contacts(Sha256& hash, std::span<const MuscleContact> contacts) {
  const std::size_t count = contacts.size();
  hash.add(std::as_bytes(std::span(&count, 1)));
  for (const MuscleContact& contact : contacts) {
    const std::array<int, 3> indices{contact.node, contact.muscle, contact.triangle};
    const std::array<Vec3, 2> vectors{contact.weights, contact.normal};
    hash.add(std::as_bytes(std::span(indices)));
    hash.add(std::as_bytes(std::span(&contact.depth_m, 1)));
    hash.add(std::as_bytes(std::span(vectors)));
  }
}

std::string text_of(Sha256& hash) { return hash.hex_digest().substr(0, 16); }

class MuscleReplayer {
 public:
  MuscleReplayer(const ReplayCase& replay, FrameSource& recording, const std::function<void()>& report)
      : m_replay(replay), m_recording(recording), m_report(report), m_bodies(replay.scene.bodies()) {
    for (const SceneMusclePair& pair : replay.scene.muscle_pairs) m_pairs.push_back(pair.muscles);
  }

  MuscleReplay run() {
    {
      const ScopedTimer timer(m_result.build_ns);
      m_detectors = make_muscle_detectors(m_replay.scene, m_replay.colliders, m_replay.threads);
    }
    for (const auto& detector : m_detectors) m_result.structure_bytes += detector->structure_bytes();
    m_result.contact_hash = timed_pass();
    if (m_replay.judge) {
      m_result.deterministic = judged_pass() == m_result.contact_hash;
    }
    return std::move(m_result);
  }

 private:
  template <typename Look>
  void for_each_frame(const Look& look) {
    const auto lead_in = [&](const RecordedStep& step) {
      for (const auto& detector : m_detectors) detector->detect(step.muscle_positions, m_found);
    };
    for_each_replayed_frame(m_recording, m_replay.stride, m_frame, lead_in, [&](const RecordedFrame& frame) {
      look(frame);
      m_report();
    });
  }

  std::string timed_pass() {
    Sha256 hash;
    for_each_frame([&](const RecordedFrame& frame) {
      MuscleReplayRecord record;
      record.frame = frame.frame;
      record.angle_deg = frame.angle_deg;
      record.warm_up = static_cast<int>(m_result.records.size()) < m_replay.warm_up_frames;
      record.iterations = static_cast<int>(frame.steps.size());
      for (std::size_t pair = 0; pair < m_pairs.size(); ++pair) {
        const auto& [first, second] = m_pairs[pair];
        record.pairs.push_back({m_bodies[static_cast<std::size_t>(first)].name,
                                m_bodies[static_cast<std::size_t>(second)].name,
                                m_replay.colliders.of_muscle_pairs[pair].entry->name, 0, 0});
      }
      const ContextSwitches before = context_switches();
      for (const RecordedStep& step : frame.steps) time_step(step, record, hash);
      record.involuntary_switches = (context_switches() - before).involuntary;
      m_result.records.push_back(std::move(record));
    });
    return text_of(hash);
  }

  void time_step(const RecordedStep& step, MuscleReplayRecord& record, Sha256& hash) {
    m_positions = step.muscle_positions;  // the loop that this stands for has just written them
    for (const auto& detector : m_detectors) {
      Nanoseconds detect_ns = 0;
      {
        const ScopedTimer timer(detect_ns);
        detector->detect(m_positions, m_found);
      }
      for (const PairTime& time : detector->pair_times()) {
        PairReplay& pair = record.pairs[pair_index(m_pairs, time.muscles.first, time.muscles.second)];
        *pair.detect_ns += time.detect_ns;
        *pair.backend_ns += detect_ns;
      }
      for (const MuscleContact& contact : m_found) ++record.pairs[pair_of(contact.node, contact.muscle)].contacts;
      add_contacts(hash, m_found);
    }
  }

  [[nodiscard]] std::size_t pair_of(int node, int muscle) const {
    return pair_index(m_pairs, static_cast<int>(body_of(m_bodies, node)), muscle);
  }

  std::string judged_pass() {
    MuscleReferee referee(m_replay.scene.muscle_mesh, judged_muscles_of(m_replay.scene));
    Sha256 hash;
    std::vector<AnswerErrors> all(m_pairs.size());
    std::vector<Contact> truth;
    auto record = m_result.records.begin();
    for_each_frame([&](const RecordedFrame& frame) {
      std::vector<AnswerErrors> errors(m_pairs.size());
      for (const RecordedStep& step : frame.steps) {
        std::vector<Contact> answered;
        for (const auto& detector : m_detectors) {
          detector->detect(step.muscle_positions, m_found);
          add_contacts(hash, m_found);
          for (const MuscleContact& each : m_found) {
            answered.push_back({each.node, each.muscle, each.depth_m, each.normal});
          }
        }
        referee.judge(step.muscle_positions, truth);
        measure(referee, step.muscle_positions, by_pair(answered), by_pair(truth), errors);
      }
      for (std::size_t pair = 0; pair < m_pairs.size(); ++pair) {
        record->pairs[pair].accuracy = accuracy_of(errors[pair]);
        all[pair].add(errors[pair]);
      }
      ++record;
    });
    for (const AnswerErrors& errors : all) m_result.accuracy.push_back(accuracy_of(errors));
    return text_of(hash);
  }

  /// In the order that errors are measured in.
  [[nodiscard]] std::vector<std::vector<Contact>> by_pair(std::span<const Contact> contacts) const {
    std::vector<std::vector<Contact>> sorted(m_pairs.size());
    for (const Contact& contact : contacts) sorted[pair_of(contact.node, contact.bone)].push_back(contact);
    for (std::vector<Contact>& of_pair : sorted) {
      std::ranges::sort(of_pair, {}, [](const Contact& contact) { return std::pair(contact.bone, contact.node); });
    }
    return sorted;
  }

  void measure(const MuscleReferee& referee, std::span<const Vec3> positions,
               const std::vector<std::vector<Contact>>& answered, const std::vector<std::vector<Contact>>& truth,
               std::vector<AnswerErrors>& errors) const {
    const auto surface_at = [&](const Contact& contact) {
      return referee.distance(contact.bone, positions[static_cast<std::size_t>(contact.node)]);
    };
    for (std::size_t pair = 0; pair < m_pairs.size(); ++pair) {
      measure_answer(surface_at, answered[pair], true, truth[pair], m_replay.band_m, errors[pair]);
    }
  }

  const ReplayCase& m_replay;
  FrameSource& m_recording;
  const std::function<void()>& m_report;
  std::vector<Body> m_bodies;
  std::vector<MusclePair> m_pairs;
  std::vector<std::unique_ptr<MuscleContactDetector>> m_detectors;
  MuscleReplay m_result;
  RecordedFrame m_frame;
  std::vector<Vec3> m_positions;
  std::vector<MuscleContact> m_found;
};

}  // namespace

MuscleReplay replay_muscles(const ReplayCase& replay, FrameSource& recording, const std::function<void()>& report) {
  return MuscleReplayer(replay, recording, report).run();
}

}  // namespace musclebench

#include "bench/cases/record_case.hpp"

#include <fmt/format.h>

#include "bench/cases/divergence.hpp"

namespace musclebench {

namespace {

/// Writes every collision step of the simulation that it watches.
class StepWriter final : public CollisionObserver {
 public:
  StepWriter(RecordingWriter& writer, bool muscle_contact) : m_writer(writer), m_muscle_contact(muscle_contact) {}
  /// Whether all positions so far could be written; the others have blown up.
  [[nodiscard]] bool complete() const { return m_complete; }

  void before_stages(std::span<const Vec3> positions) override {
    if (m_muscle_contact) m_muscle_positions.assign(positions.begin(), positions.end());
  }
  void before_detection(const CollisionStep& step) override {
    m_complete = m_complete && m_writer.add_step(step.substep_start, step.previous_bone_poses, step.positions,
                                                 step.bone_poses, m_muscle_positions);
  }
  void after_detection(const CollisionStep& /*step*/, std::span<const Contact> /*contacts*/) override {}

 private:
  RecordingWriter& m_writer;
  bool m_muscle_contact;
  std::vector<Vec3> m_muscle_positions;
  bool m_complete = true;
};

}  // namespace

std::string record_frames(Simulation& simulation, const Scene& scene, RecordingWriter& writer,
                          const std::function<void(int frames_done)>& report) {
  StepWriter steps(writer, !scene.muscle_pairs.empty());
  for (int frame = 1; frame <= scene.loop.frames; ++frame) {
    simulation.step_frame(frame, &steps);
    std::string lost = describe_divergence(simulation, frame);
    if (!lost.empty()) {
      return lost;
    }
    if (!steps.complete()) {
      return fmt::format("frame {}: a node left the scene within a substep", frame);
    }
    report(frame);
  }
  return "";
}

}  // namespace musclebench

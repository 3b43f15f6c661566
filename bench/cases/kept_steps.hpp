#pragma once

#include <utility>
#include <vector>

#include "core/pbd/simulation.hpp"
#include "core/recording/recording.hpp"

namespace musclebench {

/// Keeps the input of each collision step that it sees.
class KeptSteps final : public CollisionObserver {
 public:
  explicit KeptSteps(bool muscle_contact) : m_muscle_contact(muscle_contact) {}

  [[nodiscard]] std::vector<RecordedStep> take() { return std::move(m_steps); }

  void before_stages(std::span<const Vec3> positions) override {
    if (m_muscle_contact) m_muscle_positions.assign(positions.begin(), positions.end());
  }
  void before_detection(const CollisionStep& step) override {
    m_steps.push_back({{step.substep_start.begin(), step.substep_start.end()},
                       {step.previous_bone_poses.begin(), step.previous_bone_poses.end()},
                       {step.positions.begin(), step.positions.end()},
                       {step.bone_poses.begin(), step.bone_poses.end()},
                       m_muscle_positions});
  }
  void after_detection(const CollisionStep& /*step*/, std::span<const Contact> /*contacts*/) override {}

 private:
  bool m_muscle_contact;
  std::vector<Vec3> m_muscle_positions;
  std::vector<RecordedStep> m_steps;
};

}  // namespace musclebench

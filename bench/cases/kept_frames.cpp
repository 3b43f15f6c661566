#include "bench/cases/kept_frames.hpp"

#include <utility>

namespace musclebench {

namespace {

RecordedStep recorded(const CollisionStep& step, const std::vector<Vec3>& muscle_positions) {
  return {{step.substep_start.begin(), step.substep_start.end()},
          {step.previous_bone_poses.begin(), step.previous_bone_poses.end()},
          {step.positions.begin(), step.positions.end()},
          {step.bone_poses.begin(), step.bone_poses.end()},
          muscle_positions};
}

}  // namespace

KeptFrames::KeptFrames(int nodes, std::span<const int> free_nodes, bool muscle_contact) {
  m_header.nodes = nodes;
  m_header.muscle_contact = muscle_contact;
  m_header.free_nodes.assign(free_nodes.begin(), free_nodes.end());
}

void KeptFrames::begin_frame(int frame, double angle_deg) {
  m_header.angles_deg.push_back(angle_deg);
  m_frames.push_back({frame, angle_deg, {}, std::exchange(m_lead_in, std::nullopt)});
  m_is_leading_in = false;
}

void KeptFrames::begin_lead_in() { m_is_leading_in = true; }

void KeptFrames::before_stages(std::span<const Vec3> positions) {
  if (m_header.muscle_contact) m_muscle_positions.assign(positions.begin(), positions.end());
}

void KeptFrames::before_detection(const CollisionStep& step) {
  if (m_is_leading_in) {
    m_lead_in = recorded(step, m_muscle_positions);
  } else {
    m_frames.back().steps.push_back(recorded(step, m_muscle_positions));
  }
}

}  // namespace musclebench

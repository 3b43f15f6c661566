#include "bench/cases/kept_frames.hpp"

#include <utility>

namespace musclebench {

namespace {

RecordedStep recorded(const CollisionStep& step) {
  return {{step.substep_start.begin(), step.substep_start.end()},
          {step.previous_bone_poses.begin(), step.previous_bone_poses.end()},
          {step.positions.begin(), step.positions.end()},
          {step.bone_poses.begin(), step.bone_poses.end()}};
}

}  // namespace

KeptFrames::KeptFrames(int nodes, std::span<const int> free_nodes) {
  m_header.nodes = nodes;
  m_header.free_nodes.assign(free_nodes.begin(), free_nodes.end());
}

void KeptFrames::begin_frame(int frame, double angle_deg) {
  m_header.angles_deg.push_back(angle_deg);
  m_frames.push_back({frame, angle_deg, {}, std::exchange(m_lead_in, std::nullopt)});
  m_is_leading_in = false;
}

void KeptFrames::begin_lead_in() { m_is_leading_in = true; }

void KeptFrames::before_detection(const CollisionStep& step) {
  if (m_is_leading_in) {
    m_lead_in = recorded(step);
  } else {
    m_frames.back().steps.push_back(recorded(step));
  }
}

}  // namespace musclebench

#include "core/pbd/simulation.hpp"

#include <cmath>
#include <utility>

namespace musclebench {

void LastDetection::before_detection(const CollisionStep& step) {
  if (!step.last_of_frame) {
    return;
  }
  substep_start.assign(step.substep_start.begin(), step.substep_start.end());
  previous_bone_poses.assign(step.previous_bone_poses.begin(), step.previous_bone_poses.end());
  positions.assign(step.positions.begin(), step.positions.end());
  bone_poses.assign(step.bone_poses.begin(), step.bone_poses.end());
  contacts.reserve(bone_poses.size() * positions.size());
}

void LastDetection::after_detection(const CollisionStep& step, std::span<const Contact> detected) {
  if (step.last_of_frame) {
    contacts.assign(detected.begin(), detected.end());
  }
}

Simulation::Simulation(const LoopParameters& loop, Particles particles, std::vector<int> free_nodes,
                       std::vector<std::unique_ptr<Effect>> effects, CollisionBackend& backend, ResponseKind response,
                       PoseFunction poses)
    : m_loop(loop),
      m_particles(std::move(particles)),
      m_free_nodes(std::move(free_nodes)),
      m_effects(std::move(effects)),
      m_backend(backend),
      m_response(response),
      m_pose_function(std::move(poses)) {
  m_pose_function(0, m_poses);
  m_previous_poses = m_poses;
  // Reserved for the most contacts possible, so that no timed frame allocates memory.
  m_contacts.reserve(m_poses.size() * m_free_nodes.size());
  m_response.reserve(m_particles.size(), m_poses.size());
  m_times.effects_ns.reserve(m_effects.size());
}

const StageTimes& Simulation::step_frame(int frame, CollisionObserver* observer) {
  m_times = StageTimes{.effects_ns = std::move(m_times.effects_ns)};
  m_times.effects_ns.assign(m_effects.size(), 0);
  const Nanoseconds start_ns = monotonic_now_ns();
  for (int substep = 1; substep <= m_loop.substeps; ++substep) {
    m_previous_poses.swap(m_poses);
    const double part = m_loop.interpolate_poses ? static_cast<double>(substep) / m_loop.substeps : 1.0;
    m_pose_function(frame - 1 + part, m_poses);
    const SubstepInput input{m_loop.time_step_s, m_poses};

    for (std::size_t i = 0; i < m_effects.size(); ++i) {
      const ScopedTimer timer(m_times.effects_ns[i]);
      m_effects[i]->apply_force(m_particles, input);
    }
    {
      const ScopedTimer timer(m_times.predict_ns);
      predict(input);
    }
    for (int iteration = 1; iteration <= m_loop.iterations; ++iteration) {
      for (std::size_t i = 0; i < m_effects.size(); ++i) {
        const ScopedTimer timer(m_times.effects_ns[i]);
        m_effects[i]->project(m_particles, input);
      }
      collide(substep == m_loop.substeps && iteration == m_loop.iterations, observer);
    }
    const ScopedTimer timer(m_times.finish_ns);
    finish_substep();
  }
  m_times.frame_ns = monotonic_now_ns() - start_ns - m_times.recording_ns;
  return m_times;
}

void Simulation::predict(const SubstepInput& input) {
  const double damping = std::exp(-m_loop.damping_per_s * input.time_step_s);
  for (const int node : m_free_nodes) {
    Vec3& velocity = m_particles.velocities[node];
    velocity *= damping;
    m_particles.predicted[node] = m_particles.positions[node] + input.time_step_s * velocity;
  }
}

void Simulation::collide(bool last_of_frame, CollisionObserver* observer) {
  const CollisionStep step{m_particles.positions, m_previous_poses, m_particles.predicted, m_poses, last_of_frame};
  if (observer != nullptr) {
    const ScopedTimer timer(m_times.recording_ns);
    observer->before_detection(step);
  }
  {
    const ScopedTimer timer(m_times.update_ns);
    m_backend.update(m_poses, m_particles.predicted);
  }
  {
    const ScopedTimer timer(m_times.detect_ns);
    m_backend.detect(m_particles.predicted, m_free_nodes, m_contacts);
  }
  if (observer != nullptr) {
    const ScopedTimer timer(m_times.recording_ns);
    observer->after_detection(step, m_contacts);
  }
  const ScopedTimer timer(m_times.respond_ns);
  m_response.resolve(m_backend, {m_particles.positions, m_previous_poses, m_poses}, m_contacts, m_particles.predicted);
}

void Simulation::finish_substep() {
  const double per_time_step = 1.0 / m_loop.time_step_s;
  for (const int node : m_free_nodes) {
    m_particles.velocities[node] = per_time_step * (m_particles.predicted[node] - m_particles.positions[node]);
  }
  m_particles.positions = m_particles.predicted;
}

}  // namespace musclebench

#pragma once

#include <memory>
#include <vector>

#include "core/contact/collision_backend.hpp"
#include "core/contact/response.hpp"
#include "core/effects/reference/scalar_effect.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

/// The loop of `Simulation` over scalar effects, on one thread.
class ScalarLoop {
 public:
  ScalarLoop(const Scene& scene, CollisionBackend& backend, ResponseKind response);

  void step_frame(int frame);
  [[nodiscard]] const std::vector<Vec3>& positions() const { return m_positions; }

 private:
  const Scene& m_scene;
  CollisionBackend& m_backend;
  Response m_response;
  std::vector<Vec3> m_positions;
  std::vector<Vec3> m_predicted;
  std::vector<Vec3> m_velocities;
  std::vector<double> m_inverse_masses;
  std::vector<int> m_free_nodes;
  double m_damping_per_s = 0;
  std::vector<std::unique_ptr<ScalarEffect>> m_effects;
  std::vector<RigidMotion> m_poses;
  std::vector<RigidMotion> m_previous_poses;
  std::vector<Contact> m_contacts;
};

}  // namespace musclebench

#pragma once

#include <limits>
#include <string>
#include <vector>

#include "core/contact/response.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// Why forces of a run would mean nothing; empty where they mean something. Each is a sentence that names the cure.
struct ForceObstacles {
  std::string contacts;     ///< of the contacts' forces
  std::string attachments;  ///< of the attachments' forces
  std::string unsettled;    ///< why forces that are told may be wrong; no obstacle
  /// The longest time step with which one iteration is within 5 % of what many give, s.
  double settled_step_s = std::numeric_limits<double>::infinity();

  /// Of both, one after the other, without repetition.
  [[nodiscard]] std::string text() const;
};

/// The obstacles in a scene, given the kinds of its responses (`Scene::responses`).
ForceObstacles force_obstacles(const Scene& scene, const std::vector<ResponseKind>& responses);

}  // namespace musclebench

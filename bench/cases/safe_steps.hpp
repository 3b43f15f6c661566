#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/check/scene_check.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// The largest steps at which runs of a scene stayed right with one backend: no node on the wrong side of a bone, the
/// volume kept. Infinite where nothing was seen to go wrong, 0 where nothing was right.
struct SafeStep {
  std::string backend;
  std::string response;
  bool guard = false;                                            ///< the tunnelling guard
  double turn_deg = std::numeric_limits<double>::infinity();     ///< of a bone in a frame
  double time_step_s = std::numeric_limits<double>::infinity();  ///< of a substep
};

/// What `tools/safe-step` found for a scene.
struct SafeSteps {
  std::string file;  ///< for messages
  std::string scene;
  std::vector<SafeStep> steps;
};

/// Reads `safe_step.json`. Throws InputError that names file and key.
SafeSteps read_safe_steps(const std::filesystem::path& file);

/// Why runs of the scene, as it is, go wrong with the backend and the response; nothing where they do not, or where
/// nothing is known.
std::optional<std::string> why_unsafe(const SafeSteps& known, const Scene& scene, const std::string& backend,
                                      const std::string& response);

/// Rule `step_beyond_safe`: each backend (`only`: that one) and response whose largest safe step the scene exceeds.
Findings safe_step_findings(const SafeSteps& known, const Scene& scene, const std::string& only = "");

}  // namespace musclebench

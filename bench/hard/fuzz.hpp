#pragma once

#include <string>

#include "bench/hard/fuzz_scene.hpp"

namespace musclebench {

/// What one random scene came to. A line that says why it is wrong; empty: it holds, or it was refused.
struct FuzzOutcome {
  std::string wrong = {};
  std::string refused = {};
  std::string status = {};  ///< of a run that went to its end
};

/// Runs the scene in a process of its own and holds it against what no scene may break: it ends; every position and
/// figure is a number and within ten diagonals of the scene; it diverges only where a muscle that nothing holds may
/// fall or be thrown as far, by g t^2 / 2 and twice the speed of the fastest bone; an exact backend misses and invents
/// no contact; a run that is `ok` has no node on the wrong side and kept its volume.
FuzzOutcome run_fuzz_scene(const FuzzScene& scene, double seconds);

/// The smallest scene that is found to be wrong, too, by leaving out one piece after the other.
FuzzScene shrunk(FuzzScene scene, double seconds);

}  // namespace musclebench

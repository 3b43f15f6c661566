#pragma once

#include <string>
#include <vector>

#include "bench/cases/run_case.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// A small scene for any combination of effects: a ball that is bound to a plate, touches a second ball and is pressed
/// by a rod, which it is bound to, too, where fibres pull. `effects` have their default parameters. `subdivisions`: of
/// the balls.
Scene combination_scene(const std::vector<std::string>& effects, int subdivisions = 2);

/// Its run, not judged.
RunCase combination_case(const Scene& scene, const BackendEntry& backend = exact_backend());

}  // namespace musclebench

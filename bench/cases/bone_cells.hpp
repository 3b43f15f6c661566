#pragma once

#include <functional>
#include <vector>

#include "bench/cases/case.hpp"
#include "core/scene/check/scene_check.hpp"

namespace musclebench {

/// Builds the backends of the case and asks them how fine they are, a bone each. Throws InputError where parameters do
/// not fit the scene.
std::vector<BoneCells> bone_cells(const Case& resolved, const std::function<void(double share)>& report = {});

}  // namespace musclebench

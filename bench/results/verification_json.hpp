#pragma once

#include <string>

#include "bench/cases/verification.hpp"
#include "bench/results/manifest.hpp"

namespace musclebench {

/// What `verify --json` prints of one surface of a bone, `repaired` or `as shipped`: `bone`, `surface`, `diagonal_m`,
/// `agreed_m`, `seconds`, `held`, and `pairs` (`first`, `second`, `points`, `inside`, `largest_difference_m`,
/// `worst_point_m`, `sign_differences`, `held`).
Json json_of(const SurfaceVerification& verification, const std::string& bone, const std::string& surface);

}  // namespace musclebench

#pragma once

#include "bench/results/manifest.hpp"

namespace musclebench {

/// `schema` of the catalogue.
inline constexpr int catalogue_schema = 1;

/// What this build has: backends with their parameters, capabilities and studies, responses, effects, loop, presets and
/// scenes (`musclebench list --json`). Tools and reports know backends from here only.
Json catalogue();

}  // namespace musclebench

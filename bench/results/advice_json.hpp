#pragma once

#include "bench/cases/advice.hpp"
#include "bench/results/manifest.hpp"

namespace musclebench {

/// What `advise --json` prints of its search: `measured` (`configuration`, `backend`, `parameters`, `error_m`,
/// `max_error_m`, `contacts` or null, `collision_ns` with `median`, `low`, `high`, `build_ns`, `structure_bytes`,
/// `holds`), `omitted` (`configuration`, `reason`), and the configurations `chosen`, `best` and `unit_of_price` as
/// texts or null.
Json json_of(const Advice& advice, double wanted_m);

}  // namespace musclebench

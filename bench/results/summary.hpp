#pragma once

#include <string>
#include <vector>

#include "bench/cases/probe_case.hpp"
#include "bench/cases/run_case.hpp"
#include "core/base/scoped_timer.hpp"

namespace musclebench {

/// The median in milliseconds, as summaries print it; says so where there are no values.
std::string median_ms(std::vector<Nanoseconds> values);

/// What `run` prints, without where it was written: never better than the run was.
std::string run_summary(const RunCase& run, const RunResult& result);

/// What `probe` prints, without where it was written. Where nothing was measured stands a dash.
std::string probe_summary(const ProbeCase& what, const ProbeResult& result);

}  // namespace musclebench

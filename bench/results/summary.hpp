#pragma once

#include <string>
#include <vector>

#include "core/base/scoped_timer.hpp"

namespace musclebench {

/// The median in milliseconds, as summaries print it; says so where there are no values.
std::string median_ms(std::vector<Nanoseconds> values);

}  // namespace musclebench

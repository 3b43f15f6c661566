#pragma once

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// No collision: the cost of the loop alone.
BackendEntry null_entry();

}  // namespace musclebench

#pragma once

#include <memory>

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// No collision: the cost of the loop alone.
std::unique_ptr<CollisionBackend> make_null_backend(const Parameters& parameters);
BackendEntry null_entry();

}  // namespace musclebench

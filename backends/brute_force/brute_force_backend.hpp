#pragma once

#include <memory>

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// The truth of contacts by definition: every node against every triangle, the sign by the full winding number.
std::unique_ptr<CollisionBackend> make_brute_force_backend(const Parameters& parameters);
BackendEntry brute_force_entry();

}  // namespace musclebench

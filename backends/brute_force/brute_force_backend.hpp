#pragma once

#include <memory>

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// Contacts by definition: every node against every triangle, the side by the exact winding number.
std::unique_ptr<CollisionBackend> make_brute_force_backend(const Parameters& parameters);
BackendEntry brute_force_entry();

}  // namespace musclebench

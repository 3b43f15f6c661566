#pragma once

#include <memory>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// Contacts by definition: every node against every triangle, the side by the exact winding number.
std::unique_ptr<CollisionBackend> make_brute_force_backend(const Parameters& parameters);
std::vector<ParameterSpec> brute_force_parameters();

}  // namespace musclebench

#pragma once

#include <memory>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// The truth of contacts by definition: every node against every triangle, the sign by the full winding number.
std::unique_ptr<CollisionBackend> make_brute_force_backend(const Parameters& parameters);
std::vector<ParameterSpec> brute_force_parameters();

}  // namespace musclebench

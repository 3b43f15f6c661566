#pragma once

#include <memory>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// No collision: the cost of the loop alone.
std::unique_ptr<CollisionBackend> make_null_backend(const Parameters& parameters);
std::vector<ParameterSpec> null_parameters();

}  // namespace musclebench

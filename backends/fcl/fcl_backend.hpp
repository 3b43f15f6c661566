#pragma once

#include <memory>

#include "backends/fcl/fcl_options.hpp"
#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// The backend `fcl`: the Flexible Collision Library 0.7, by default as the paper uses it (see surface_backend.hpp),
/// with parameters (`fcl_parameters`) for what else it offers (see node_backend.hpp). Throws InputError for a
/// combination that FCL cannot answer; one that it answers wrongly runs, and answers wrongly.
std::unique_ptr<CollisionBackend> make_fcl_backend(const Parameters& parameters);
BackendEntry fcl_entry();

}  // namespace musclebench

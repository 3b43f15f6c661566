#pragma once

#include <memory>

#include "backends/fcl/fcl_options.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// Each node by itself against each bone's tree (see NodeQueries): what FCL can do where nodes are what matters. The
/// muscle's surface is not used.
std::unique_ptr<CollisionBackend> make_node_backend(const FclOptions& options);

}  // namespace musclebench

#pragma once

#include <memory>

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// The paper's voxelisation (section II-A): an occupancy grid a bone in rest pose, looked up with the node in the
/// bone's rest frame. Contacts have no depth and no normal.
std::unique_ptr<CollisionBackend> make_voxel_backend(const Parameters& parameters);
BackendEntry voxel_entry();

}  // namespace musclebench

#pragma once

#include <memory>

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// The paper's voxelisation (II-A): a bit grid a bone in rest pose; nodes go through the inverse bone pose. Contacts
/// carry no depth and no normal.
std::unique_ptr<CollisionBackend> make_voxel_backend(const Parameters& parameters);
BackendEntry voxel_entry();

}  // namespace musclebench

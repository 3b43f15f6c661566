#pragma once

#include <memory>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// The paper's voxelisation (II-A): a bit grid a bone in rest pose; nodes go through the inverse bone pose. Contacts
/// carry no depth and no normal.
std::unique_ptr<CollisionBackend> make_voxel_backend(const Parameters& parameters);
std::vector<ParameterSpec> voxel_parameters();

}  // namespace musclebench

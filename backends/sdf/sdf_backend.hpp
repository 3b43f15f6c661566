#pragma once

#include <memory>
#include <vector>

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// The Discregrid method (the paper's II-B; Koschier et al. 2017), written anew: a cubic signed distance field a bone
/// over its own box, queried in the bone's rest frame. Depth and normal come from the field, so what is thinner than
/// about a cell can be missed. Outside the fields' boxes nodes are free.
std::unique_ptr<CollisionBackend> make_sdf_backend(const Parameters& parameters);
std::vector<ParameterSpec> sdf_parameters();
BackendEntry sdf_entry();

}  // namespace musclebench

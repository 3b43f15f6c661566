#pragma once

#include <memory>
#include <vector>

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// Makes a backend with a cubic signed distance field over each bone, queried in the bone's rest frame. It is our own
/// implementation of the Discregrid method (paper, II-B; Koschier et al. 2017). Depth and normal come from the field,
/// so it can miss parts that are thinner than about one cell. A node outside the boxes of all fields is free.
///
/// `parameters` must be made from `sdf_parameters`. Throws InputError if they do not fit together.
std::unique_ptr<CollisionBackend> make_sdf_backend(const Parameters& parameters);
/// The parameters of the backend, such as the resolution of the field.
std::vector<ParameterSpec> sdf_parameters();
/// The backend's row in the table of backends.
BackendEntry sdf_entry();

}  // namespace musclebench

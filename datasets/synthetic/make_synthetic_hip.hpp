#pragma once

#include <string_view>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Makes a mesh of the synthetic hip (`synthetic_hip_mesh`), which takes up to a second: what programs have was made
/// when they were built. `name`: hip_bone, femur, or a muscle of `muscle_shape`.
TriangleMesh make_synthetic_hip_mesh(std::string_view name);

}  // namespace musclebench

#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The synthetic right hip, made by code: two bones and four muscles shaped after anatomy, with the vertex counts of
/// the paper's muscles. Metres; the hip centre is the origin, x points to the subject's left, y backwards, z up. Hip
/// flexion is a right-handed rotation of the femur about (-1, 0, 0). Every surface is closed, manifold and outward, one
/// component, and the same for any number of threads. They were made when the program was built. Throws InputError for
/// an unknown name.
TriangleMesh synthetic_hip_mesh(std::string_view name);

/// hip_bone, femur, adductor_brevis, gluteus_maximus, gluteus_medius, iliacus.
std::vector<std::string> synthetic_hip_names();

}  // namespace musclebench

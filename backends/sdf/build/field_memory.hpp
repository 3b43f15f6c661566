#pragma once

#include <span>

#include "backends/sdf/build/field_builder.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// Estimate of the memory that building the field of a bone needs, in bytes. The cells of a narrow band are estimated
/// from the surface's area and volume: some 20 % too many on bones.
double bytes_to_build(const TriangleMesh& surface, const GridShape& shape, const FieldSettings& settings);

/// Throws InputError (about the parameter that chose the grid) that says how much is needed, how much is there and
/// what fits, where the fields of these bones over `shapes`, laid out by `grid`, need more memory than there is.
void require_room(std::span<const Bone> bones, std::span<const GridShape> shapes, const GridSettings& grid,
                  const FieldSettings& settings);

}  // namespace musclebench

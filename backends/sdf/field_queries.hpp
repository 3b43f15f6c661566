#pragma once

#include <span>

#include "core/base/parameters.hpp"
#include "core/contact/surface_queries.hpp"

namespace musclebench {

/// What contact of faces asks, answered by a field over a grid of cells of one size. Points beyond the field's domain
/// get the value at its border and their distance to it. Throws InputError for a field that does not tell distances
/// outside of a bone (`max_error_mm`), for one that is read from a file, and where the fields of all bones
/// need more memory than there is.
MakeSurfaceQueries make_field_queries(const Parameters& parameters, std::span<const Bone> bones);

}  // namespace musclebench

#pragma once

#include "core/base/parameters.hpp"
#include "core/contact/surface_queries.hpp"

namespace musclebench {

/// What contact of faces asks, answered by a field over a grid of cells of one size. Points beyond the field's domain
/// get the value at its border and their distance to it. Throws InputError for a field that does not tell distances
/// outside of a bone (`band_m`, `max_error_mm`), and for one that is read from a file.
MakeSurfaceQueries make_field_queries(const Parameters& parameters);

}  // namespace musclebench

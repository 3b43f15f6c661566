#pragma once

#include "backends/sdf/grid/narrow_band.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// Chooses the cells around a surface: blocks first, then the cells of those that lie across the edge of the band. The
/// same for any number of threads.
NarrowBand narrow_band(const SignedSurface& surface, const GridShape& shape, double width_m, int threads);

}  // namespace musclebench

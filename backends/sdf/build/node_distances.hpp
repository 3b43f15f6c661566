#pragma once

#include <functional>

#include "backends/sdf/grid/cubic_field.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// Sets every value that the field keeps to the exact signed distance at its node. The same bits for any number of
/// threads. `progress`, where given, is called from time to time by one thread with the share that is done.
void fill_distances(const SignedSurface& surface, CubicField& field, int threads,
                    const std::function<void(double)>& progress = {});

}  // namespace musclebench

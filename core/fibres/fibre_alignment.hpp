#pragma once

#include <vector>

#include "core/fibres/fibre_segments.hpp"

namespace musclebench {

/// |cos| of the angle between `direction` and the fibre segment closest to `point`; 0 without fibres and for a
/// direction or a fibre of length 0.
double alignment_with_nearest_fibre(const std::vector<FibreSegment>& fibres, const Vec3& point, const Vec3& direction);

}  // namespace musclebench

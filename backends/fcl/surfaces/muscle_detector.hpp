#pragma once

#include "core/contact/muscle_contact.hpp"

namespace musclebench {

/// Contacts between muscles by FCL's refitted trees (the paper's method with bones): of each node that belongs to an
/// intersecting triangle the closest of the triangles that are met. Blind to nodes deep inside. Takes the backend's
/// parameters with `query` = surfaces.
std::unique_ptr<MuscleContactDetector> make_fcl_muscle_detector(const Parameters& parameters,
                                                                const TouchingMuscles& muscles, int threads);

}  // namespace musclebench

#pragma once

#include "core/contact/muscle_contact.hpp"

namespace musclebench {

/// Contacts between muscles by refitted trees: exact, by the closest point of each node on the other muscles' surfaces.
/// `clearance_cache` is a parameter of the backend.
std::unique_ptr<MuscleContactDetector> make_bvh_muscle_detector(const Parameters& parameters,
                                                                const TouchingMuscles& muscles, int threads);

}  // namespace musclebench

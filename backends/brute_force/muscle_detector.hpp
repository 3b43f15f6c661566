#pragma once

#include "core/contact/muscle_contact.hpp"

namespace musclebench {

/// Contacts between muscles by definition: every node of one against every triangle of the other.
std::unique_ptr<MuscleContactDetector> make_brute_force_muscle_detector(const Parameters& parameters,
                                                                        const TouchingMuscles& muscles, int threads);

}  // namespace musclebench

#pragma once

#include <memory>

#include "core/contact/muscle_contact.hpp"

namespace musclebench {

/// Contact between muscles by Embree: trees that are refitted to each muscle in every step.
std::unique_ptr<MuscleContactDetector> make_embree_muscle_detector(const Parameters& parameters,
                                                                   const TouchingMuscles& muscles, int threads);

}  // namespace musclebench

#pragma once

#include <memory>

#include "core/contact/muscle_contact.hpp"

namespace musclebench {

/// Contact between muscles by CGAL: a tree that is built anew over each muscle in every step, as it cannot be refitted.
std::unique_ptr<MuscleContactDetector> make_cgal_muscle_detector(const Parameters& parameters,
                                                                 const TouchingMuscles& muscles, int threads);

}  // namespace musclebench

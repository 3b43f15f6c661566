#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// The fibres of a muscle pull its ends together: by an activation over time (`ActivationCourse`), by their length and
/// by their speed (`FibreLaw`). They hold a stretched muscle, and keep an active one taut where its ends come closer.
///
/// Fibres run along the surface from the origin to the insertion (`surface_flow`); all of them cross every section
/// between. Each triangle stands for as much of the muscle's volume as of their length, so that all together pull with
/// the stress times the physiological cross-section: the volume over the mean fibre length, at the optimal length
/// (Zajac 1989). A muscle whose nodes are not attached at two ends, or whose surface is open, has no such fibres.
std::unique_ptr<Effect> make_fibre_force(const EffectInput& input, const Parameters& parameters);
std::vector<ParameterSpec> fibre_force_parameters();

}  // namespace musclebench

#pragma once

#include <memory>
#include <span>
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
EffectEntry fibre_force_entry();

/// About the longest time step, in s, with which active fibres of this level throw no node to and fro: they pull where
/// nodes were at the start of a substep, so that light nodes of a fine mesh overshoot. Where h^2 k w <= 2, with w the
/// inverse mass and k how the pull on a node at rest grows with its place (the sum of its row's sizes, after
/// Gershgorin), half is left of what an oscillator bears. Infinite where nothing pulls. `inverse_masses`: by node,
/// 1/kg.
double longest_fibre_step_s(const EffectInput& input, const Parameters& parameters,
                            std::span<const double> inverse_masses);

}  // namespace musclebench

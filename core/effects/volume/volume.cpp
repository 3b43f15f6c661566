#include "core/effects/volume/volume.hpp"

#include "core/constraints/volume_constraints.hpp"
#include "core/effects/constraint_effect.hpp"

namespace musclebench {

namespace {

std::unique_ptr<Effect> make_volume(const EffectInput& input, const Parameters& parameters) {
  return make_constraint_effect("volume",
                                VolumeConstraints(input.mesh, input.bodies, input.order,
                                                  {.pressure = parameters.number("pressure"),
                                                   .projection_scale = parameters.number("projection_scale")}));
}

}  // namespace

std::vector<ParameterSpec> volume_parameters() {
  return {parameter::number({.name = "pressure",
                             .default_value = 1,
                             .minimum = 0.01,
                             .maximum = 100,
                             .help = "target volume over rest volume (useful: 0.5 to 2)"}),
          parameter::number({.name = "projection_scale",
                             .default_value = 1,
                             .minimum = 0,
                             .maximum = 1,
                             .help = "part of the full projection that one pass does (the paper's public code: 1/6)"})};
}

EffectEntry volume_entry() {
  return {.name = "volume",
          .help = "the closed surface keeps its volume",
          .parameters = volume_parameters(),
          .make = make_volume,
          .remedies = {{Requirement::volume}},
          .inert_at_zero = {"projection_scale"},
          .colour = "#3E5C4B"};
}

}  // namespace musclebench

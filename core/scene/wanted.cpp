#include "core/scene/wanted.hpp"

namespace musclebench {

namespace {

constexpr double mm_per_m = 1e3;
constexpr double longest_mm = 1e6;

ParameterSpec length_mm(const char* name, double default_mm, double least_mm, const char* help) {
  return parameter::number({.name = name,
                            .unit = "mm",
                            .default_value = default_mm,
                            .minimum = least_mm,
                            .maximum = longest_mm,
                            .help = help});
}

}  // namespace

std::vector<ParameterSpec> wanted_parameters() {
  const Wanted usual;
  // The Referee looks for the deepest point of a face to about a tenth of this.
  constexpr double least_depth_mm = 1e-3;
  return {length_mm("surface_mm", mm_per_m * usual.surface_m, least_depth_mm,
                    "how deep a point of a muscle may be in a bone or in another muscle"),
          parameter::number({.name = "volume_percent",
                             .unit = "%",
                             .default_value = 100 * usual.volume_share,
                             .minimum = 1e-9,
                             .maximum = 1e6,
                             .help = "how far a muscle's volume may be off its target"}),
          parameter::flag({.name = "nothing_passes",
                           .default_value = usual.nothing_passes,
                           .help = "no triangle passes through its own muscle or another one; false: one of a hundred "
                                   "may"}),
          length_mm("returns_mm", mm_per_m * usual.returned_m, 1e-6,
                    "how far (RMS) a muscle may end from where it began, once its bones are back"),
          length_mm("moment_arm_mm", 0, 0,
                    "largest change of a moment arm (RMS); fibres then have to be taut. 0: not wanted")};
}

bool asks_for(const Wanted& wanted, Requirement requirement) {
  const auto says = [&](const char* name) { return wanted.own_values.contains(name); };
  switch (requirement) {
    case Requirement::bone_depth:
    case Requirement::muscle_depth:
      return says("surface_mm");
    case Requirement::volume:
      return says("volume_percent");
    case Requirement::bone_passage:
    case Requirement::muscle_passage:
    case Requirement::self_passage:
      return says("nothing_passes");
    case Requirement::returned_shape:
      return says("returns_mm");
    case Requirement::taut_fibres:
      return says("moment_arm_mm");
    case Requirement::whole_surface:
    case Requirement::trusted_run:
      return false;
  }
  return false;
}

Wanted wanted_from(const Parameters& parameters) {
  Wanted wanted;
  wanted.surface_m = parameters.number("surface_mm") / mm_per_m;
  wanted.volume_share = parameters.number("volume_percent") / 100;
  wanted.nothing_passes = parameters.flag("nothing_passes");
  wanted.returned_m = parameters.number("returns_mm") / mm_per_m;
  if (const double arm_mm = parameters.number("moment_arm_mm"); arm_mm > 0) wanted.moment_arm_m = arm_mm / mm_per_m;
  return wanted;
}

}  // namespace musclebench

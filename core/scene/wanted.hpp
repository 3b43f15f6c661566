#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/effects/requirement.hpp"

namespace musclebench {

/// What a scene wants of its run: `[wanted]`. A search for effects adds those that it takes to hold this.
struct Wanted {
  bool is_given = false;        ///< the scene has the table, or the command line sets a value of it
  double surface_m = 1e-4;      ///< how deep a point of a muscle may be in a bone or another muscle
  double volume_share = 0.01;   ///< how far a volume may be off its target
  bool nothing_passes = false;  ///< false: one triangle of a hundred may pass through its own or another muscle
  double returned_m = 2e-3;     ///< RMS distance from the start that a muscle may have whose bones are back there
  std::map<std::string, ParameterValue> own_values = {};  ///< what the scene or the command line says itself
  std::optional<double> moment_arm_m = {};  ///< how far a moment arm may be off; nothing: arms are not wanted
};

/// The parameters of the `[wanted]` table.
std::vector<ParameterSpec> wanted_parameters();

/// Whether `own_values` says something of the requirement: a run that misses it is suspect.
bool asks_for(const Wanted& wanted, Requirement requirement);

/// `parameters` must be made from `wanted_parameters`. Neither `is_given` nor `own_values` is set.
Wanted wanted_from(const Parameters& parameters);

}  // namespace musclebench

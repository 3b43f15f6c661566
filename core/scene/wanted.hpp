#pragma once

#include <optional>
#include <vector>

#include "core/base/parameters.hpp"

namespace musclebench {

/// What a scene wants of its run: `[wanted]`. A search for effects adds those that it takes to hold this.
struct Wanted {
  bool is_given = false;         ///< the scene has the table, or the command line sets a value of it
  double surface_m = 1e-4;       ///< how deep a point of a muscle may be in a bone or another muscle
  double volume_share = 0.01;    ///< how far a volume may be off its target
  bool nothing_passes = false;   ///< false: one triangle of a hundred may pass through its own or another muscle
  double returned_m = 2e-3;      ///< RMS distance from the start that a muscle may have whose bones are back there
  bool asks_for_return = false;  ///< the distance is given: it also counts where no bone moves
  std::optional<double> moment_arm_m = {};  ///< how far a moment arm may be off; nothing: arms are not wanted
};

/// The parameters of the `[wanted]` table.
std::vector<ParameterSpec> wanted_parameters();

/// `parameters` must be made from `wanted_parameters`.
Wanted wanted_from(const Parameters& parameters);

}  // namespace musclebench

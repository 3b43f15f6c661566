#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/contact/backend_entry.hpp"

namespace musclebench {

using Settings = std::map<std::string, ParameterValue>;

/// A parameter that is made finer step by step until the wanted depth holds.
struct Refinement {
  std::string parameter;
  bool is_integer = false;
  double from = 0;           ///< coarse
  double to = 0;             ///< fine
  double factor = 2;         ///< from one step to the next; below 1 for a size
  bool interpolate = false;  ///< whether a value between two steps may be predicted
};

/// A parameter that is the wanted error itself, of structures that adapt to it.
struct WantedErrorSteps {
  std::string parameter;
  double per_metre = 1;    ///< of its unit
  double factor = 4;       ///< each step is finer by
  double coarsest_m = 0;   ///< the first step is no coarser
  double build_order = 1;  ///< building takes (1 / error)^build_order
};

/// What `advise` may try of one backend: the table [advise] of its study.toml.
struct AdvisePlan {
  std::string backend;
  bool exact = false;
  std::vector<Settings> points = {};  ///< single configurations
  std::optional<Refinement> refine = {};
  std::optional<WantedErrorSteps> wanted_error = {};
  std::optional<Settings> unit_of_price = {};  ///< whose time others are divided by
};

/// Nothing where the backend has no study or the study no [advise]. Throws InputError that names file, line and key
/// where it says what the backend has not.
std::optional<AdvisePlan> read_advise_plan(const BackendEntry& backend);

/// Of all backends of this build, in their order.
std::vector<AdvisePlan> advise_plans();

}  // namespace musclebench

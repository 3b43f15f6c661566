#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "core/base/parameters.hpp"

namespace musclebench {

/// What a scene can want of its run. In the order in which a search for effects looks after them: a torn surface spoils
/// every other figure.
enum class Requirement : std::uint8_t {
  whole_surface,   ///< edges are not torn
  volume,          ///< muscles keep their volume
  bone_passage,    ///< nothing goes through a bone
  muscle_passage,  ///< nothing goes through another muscle
  self_passage,    ///< nothing goes through its own muscle
  bone_depth,      ///< no point of a muscle is deep in a bone
  muscle_depth,    ///< no point of a muscle is deep in another
  returned_shape,  ///< a muscle whose bones are back has its shape at the start
  taut_fibres,     ///< fibres are under tension, so that moment arms mean something
  trusted_run,     ///< no outcome is beyond a limit that holds for every run (status `ok`)
};

/// As in `check --json`: "whole_surface", ...
std::string_view name_of(Requirement requirement);

/// A requirement that an effect can help a run to hold.
struct Remedy {
  Requirement requirement = Requirement::whole_surface;
  std::map<std::string, ParameterValue> values = {};  ///< parameters for that, where they differ from the defaults
};

}  // namespace musclebench

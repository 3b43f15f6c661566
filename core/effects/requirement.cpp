#include "core/effects/requirement.hpp"

#include <array>
#include <cstddef>

namespace musclebench {

std::string_view name_of(Requirement requirement) {
  constexpr std::array names{"whole_surface", "volume",       "bone_passage",   "muscle_passage", "self_passage",
                             "bone_depth",    "muscle_depth", "returned_shape", "taut_fibres",    "trusted_run"};
  return names[static_cast<std::size_t>(requirement)];
}

}  // namespace musclebench

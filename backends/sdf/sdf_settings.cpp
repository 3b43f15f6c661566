#include "backends/sdf/sdf_settings.hpp"

#include <algorithm>
#include <cctype>
#include <initializer_list>

#include <fmt/format.h>

#include "core/base/input_error.hpp"

namespace musclebench {

GridSettings grid_settings(const Parameters& parameters) {
  return {static_cast<int>(parameters.integer("cells")), parameters.number("cell_size_m"), parameters.number("margin")};
}

bool wants_octree(const Parameters& parameters) {
  const bool is_adaptive = parameters.number("max_error_mm") > 0;
  const auto refuse = [&](std::initializer_list<const char*> others, const std::string& chosen,
                          const std::string& reason) {
    for (const char* other : others) {
      if (parameters.given(other)) {
        throw InputError(fmt::format("sdf: {}", other), fmt::format("{}; leave out this or `{}`", reason, chosen));
      }
    }
  };
  if (is_adaptive) {
    refuse({"cells", "cell_size_m", "discregrid"}, "max_error_mm", "an adaptive field chooses its cells");
  } else if (!parameters.word("discregrid").empty()) {
    refuse({"cells", "cell_size_m", "margin", "structures"}, "discregrid", "a field that is read is as it was built");
  } else if (parameters.number("cell_size_m") > 0) {
    refuse({"cells"}, "cell_size_m", "the edge of the cells tells how many there are");
  }
  return is_adaptive;
}

OctreeSettings octree_settings(const Parameters& parameters) {
  OctreeSettings settings;
  settings.max_error_m = parameters.number("max_error_mm") * 1e-3;
  settings.margin = parameters.number("margin");
  return settings;
}

std::string bone_file_name(const std::string& bone_name) {
  std::string name = bone_name;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0 && c != '-' && c != '.'; }, '_');
  return name;
}

std::string margin_file_name(double margin) {
  return margin == GridSettings{}.margin ? "" : fmt::format("-margin{}", margin);
}

}  // namespace musclebench

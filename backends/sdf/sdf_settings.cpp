#include "backends/sdf/sdf_settings.hpp"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

FieldPrecision precision_named(const std::string& word) {
  if (word == "compact") {
    return FieldPrecision::compact;
  }
  return word == "float" ? FieldPrecision::single_precision : FieldPrecision::double_precision;
}

}  // namespace

GridSettings grid_settings(const Parameters& parameters) {
  return {static_cast<int>(parameters.integer("cells")), parameters.number("cell_size_m"), parameters.number("margin")};
}

FieldSettings field_settings(const Parameters& parameters) {
  return {precision_named(parameters.word("precision")), parameters.number("band_m")};
}

bool wants_octree(const Parameters& parameters) {
  if (parameters.number("max_error_mm") <= 0) {
    return false;
  }
  const auto refuse = [](const std::string& parameter) {
    throw InputError("sdf: " + parameter, "an adaptive field chooses its cells; leave out this or `max_error_mm`");
  };
  for (const char* other : {"cell_size_m", "band_m"}) {
    if (parameters.number(other) > 0) {
      refuse(other);
    }
  }
  if (!parameters.word("discregrid").empty()) {
    refuse("discregrid");
  }
  return true;
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

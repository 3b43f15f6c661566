#include "core/scene/read_placement.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

double read_unit(const TomlTable& table) {
  constexpr std::array units{std::pair{"m", 1.0}, std::pair{"cm", 100.0}, std::pair{"mm", 1000.0}};
  const std::string name = table.word_or("unit", "m");
  const auto unit = std::ranges::find(units, name, [](const auto& known) { return std::string(known.first); });
  if (unit != units.end()) return unit->second;
  throw InputError(
      table.location("unit"),
      fmt::format("'{}' is not one of mm, cm, m; for another unit, give its length in metres as scale", name));
}

Vec3 read_scale(const TomlTable& table) {
  constexpr double least = 1e-9;
  constexpr double most = 1e9;
  if (!table.has("scale")) return Vec3::Ones();
  const Vec3 scale =
      table.is_list("scale") ? table.point("scale") : Vec3(Vec3::Constant(table.number("scale", -most, most)));
  if (scale.minCoeff() < 0) {
    throw InputError(table.location("scale"),
                     "is negative, which would turn the surface inside out; mirror the mesh "
                     "in its file");
  }
  if (scale.minCoeff() < least || scale.maxCoeff() > most) {
    throw InputError(table.location("scale"), fmt::format("has to be from {:g} to {:g}", least, most));
  }
  return scale;
}

/// Within `most` along each axis.
Vec3 read_vector(const TomlTable& table, std::string_view key, double most) {
  if (!table.has(key)) return Vec3::Zero();
  const Vec3 vector = table.point(key);
  if (vector.cwiseAbs().maxCoeff() > most) {
    throw InputError(table.location(key), fmt::format("is beyond {:g} in size", most));
  }
  return vector;
}

}  // namespace

MeshPlacement read_placement(const TomlTable& table) {
  constexpr double largest_angle_deg = 3600;
  constexpr double farthest_away_m = 1e9;  // beyond it rounding moves a mesh by more than a micrometre
  return {read_unit(table), read_scale(table), read_vector(table, "rotate_deg", largest_angle_deg),
          read_vector(table, "translate_m", farthest_away_m)};
}

}  // namespace musclebench

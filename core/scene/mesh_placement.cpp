#include "core/scene/mesh_placement.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

namespace {

double read_unit(const TomlTable& table) {
  constexpr std::array units{std::pair{"m", 1.0}, std::pair{"cm", 100.0}, std::pair{"mm", 1000.0}};
  const std::string name = table.word_or("unit", "m");
  const auto unit = std::ranges::find(units, name, [](const auto& known) { return std::string(known.first); });
  if (unit != units.end()) return unit->second;
  throw InputError(table.location("unit"),
                   fmt::format("'{}' is not one of mm, cm, m; of another unit, give its metres as scale", name));
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

/// Quarter turns are exact: where a frame only swaps axes, coordinates keep their digits.
Mat3 turn_about(const Vec3& axis, double degrees) {
  const Mat3 turn = RigidMotion::about_axis(axis, Vec3::Zero(), degrees / degrees_per_radian).rotation;
  return std::fmod(degrees, 90) == 0 ? Mat3(turn.array().round() + 0.0) : turn;
}

}  // namespace

void MeshPlacement::apply_to(std::vector<Vec3>& vertices) const {
  const Mat3 turn = turn_about(Vec3::UnitZ(), rotate_deg.z()) * turn_about(Vec3::UnitY(), rotate_deg.y()) *
                    turn_about(Vec3::UnitX(), rotate_deg.x());
  for (Vec3& vertex : vertices) {
    // Dividing rounds as reading the same number in metres does: 12.3 mm are the bits of 0.0123 more often.
    if (units_per_metre != 1) vertex /= units_per_metre;
    if (scale != Vec3::Ones()) vertex = vertex.cwiseProduct(scale).eval();
    if (!rotate_deg.isZero(0)) vertex = (turn * vertex).eval();
    if (!translate_m.isZero(0)) vertex += translate_m;
  }
}

MeshPlacement read_placement(const TomlTable& table) {
  constexpr double largest_angle_deg = 3600;
  constexpr double farthest_away_m = 1e9;  // beyond it rounding moves a mesh by more than a micrometre
  return {read_unit(table), read_scale(table), read_vector(table, "rotate_deg", largest_angle_deg),
          read_vector(table, "translate_m", farthest_away_m)};
}

}  // namespace musclebench

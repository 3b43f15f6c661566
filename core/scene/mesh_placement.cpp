#include "core/scene/mesh_placement.hpp"

#include <cmath>

#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

namespace {

/// Quarter turns are exact: where a frame only swaps axes, coordinates keep their digits.
Mat3 turn_about(const Vec3& axis, double degrees) {
  const Mat3 turn = RigidMotion::about_axis(axis, Vec3::Zero(), degrees / degrees_per_radian).rotation;
  return std::fmod(degrees, 90) == 0 ? Mat3(turn.array().round() + 0.0) : turn;
}

}  // namespace

void MeshPlacement::apply_to(std::vector<Vec3>& vertices) const {
  for (Vec3& vertex : vertices) {
    // Dividing rounds as reading the same number in metres does: 12.3 mm are the bits of 0.0123 more often.
    if (units_per_metre != 1) vertex /= units_per_metre;
  }
  apply_to_metres(vertices);
}

void MeshPlacement::apply_to_metres(std::vector<Vec3>& points) const {
  const Mat3 turn = turn_about(Vec3::UnitZ(), rotate_deg.z()) * turn_about(Vec3::UnitY(), rotate_deg.y()) *
                    turn_about(Vec3::UnitX(), rotate_deg.x());
  for (Vec3& point : points) {
    if (scale != Vec3::Ones()) point = point.cwiseProduct(scale).eval();
    if (!rotate_deg.isZero(0)) point = (turn * point).eval();
    if (!translate_m.isZero(0)) point += translate_m;
  }
}

bool MeshPlacement::changes_metres() const {
  return scale != Vec3::Ones() || !rotate_deg.isZero(0) || !translate_m.isZero(0);
}

}  // namespace musclebench

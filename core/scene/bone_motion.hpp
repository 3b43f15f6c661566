#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// A rotation about a fixed axis whose angle follows a table over the course of the run.
struct BoneRotation {
  Vec3 axis = Vec3::UnitX();  ///< unit, right-handed
  Vec3 centre_m = Vec3::Zero();
  std::vector<double> times;       ///< ascending, any unit: only proportions count; empty: no rotation
  std::vector<double> angles_rad;  ///< as many, from the pose in which the meshes are stored
  bool there_and_back = true;      ///< the table is run through forwards, then backwards

  /// `progress` from 0 at the start to 1 at the end of the run.
  [[nodiscard]] double angle_rad(double progress) const;
  [[nodiscard]] RigidMotion pose(double progress) const;
  /// Whether the angle changes.
  [[nodiscard]] bool turns() const;
};

/// How a bone moves: no rotation (it stands still), one, or several. As with the coordinates of an OpenSim joint, each
/// turns about an axis that those before it have turned: x = R_0 R_1 ... R_n x_rest, with axes and centres as at rest.
struct BoneMotion {
  std::vector<BoneRotation> rotations;

  [[nodiscard]] RigidMotion pose(double progress) const;
  /// Of the rotation that is farthest from rest.
  [[nodiscard]] double largest_angle_rad(double progress) const;
  [[nodiscard]] bool turns() const;
};

/// A column of an OpenSim motion file (.mot) and its time column.
struct MotionTable {
  std::vector<double> times;
  std::vector<double> values;  ///< degrees, also where the file says `inDegrees=no`
};

/// Reads `column` of the OpenSim motion file at `path`. Only the rows that are there count, whatever its header
/// announces. Throws InputError that names file and line for a missing column (with the nearest known), a value that is
/// not finite, times that do not ascend, or fewer than two rows.
MotionTable read_motion_table(const std::filesystem::path& path, const std::string& column);

}  // namespace musclebench

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// How a bone moves: a rotation about a fixed axis whose angle follows a table over the course of the run.
struct BoneMotion {
  Vec3 axis = Vec3::UnitX();  ///< unit, right-handed
  Vec3 centre_m = Vec3::Zero();
  std::vector<double> times;       ///< ascending, any unit: only proportions count; empty: the bone stands still
  std::vector<double> angles_rad;  ///< as many, from the pose in which the meshes are stored
  bool there_and_back = true;      ///< the table is run through forwards, then backwards

  /// `progress` from 0 at the start to 1 at the end of the run.
  [[nodiscard]] double angle_rad(double progress) const;
  [[nodiscard]] RigidMotion pose(double progress) const;
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

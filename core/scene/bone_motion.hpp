#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// A rotation about a fixed axis. A table gives its angle during the run.
struct BoneRotation {
  Vec3 axis = Vec3::UnitX();       ///< unit vector; positive angles are right-handed
  Vec3 centre_m = Vec3::Zero();    ///< a point on the axis
  std::vector<double> times;       ///< ascending; scaled to the duration of the run; empty: no rotation
  std::vector<double> angles_rad;  ///< one for each time; 0 is the pose of the mesh files
  bool there_and_back = true;      ///< the run plays the table forwards, then backwards

  /// The angle at `progress`, which is 0 at the start and 1 at the end of the run.
  [[nodiscard]] double angle_rad(double progress) const;
  /// The pose at `progress`.
  [[nodiscard]] RigidMotion pose(double progress) const;
  /// Whether the angle changes.
  [[nodiscard]] bool turns() const;
};

/// The motion of a bone: no rotation (it stands still), one, or several. As with the coordinates of an OpenSim joint,
/// earlier rotations turn the axes of later ones: x = R_0 R_1 ... R_n x_rest. Axes and centres are given at rest.
struct BoneMotion {
  std::vector<BoneRotation> rotations;

  /// The pose at `progress`, from the rest frame to the world frame.
  [[nodiscard]] RigidMotion pose(double progress) const;
  /// The angle of the rotation that is farthest from rest.
  [[nodiscard]] double largest_angle_rad(double progress) const;
  /// Whether any angle changes.
  [[nodiscard]] bool turns() const;
};

/// A column of an OpenSim motion file (.mot) and its time column.
struct MotionTable {
  std::vector<double> times;
  std::vector<double> values;  ///< degrees, also where the file says `inDegrees=no`
};

/// Reads a column of an OpenSim motion file. Throws InputError that names file and line in these cases:
///
/// - the column is missing (the error names the nearest known one),
/// - a value is not finite, or times do not ascend,
/// - there are fewer than two rows, or the header gives another number of rows or columns.
MotionTable read_motion_table(const std::filesystem::path& path, const std::string& column);

}  // namespace musclebench

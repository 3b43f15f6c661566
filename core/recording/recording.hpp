#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// A recording is the input of every collision step of one run: what each backend is asked about, however it would
/// itself have moved the muscle.
///
/// File format, version 1, little-endian: the line `musclebench recording 1`; a header, JSON, after its length (u64);
/// one block a frame, Zstandard, after its length (u32); a length of 0; `sha256 ` and 64 hexadecimal digits of the hash
/// of all before that word. Positions are whole multiples of `rounding_m`, predicted from the steps before (StepCodec);
/// poses are stored as they are. A file reads back to the same bits on every machine.
struct RecordingHeader {
  std::string scene;         ///< name
  std::string scene_source;  ///< how the user named it: an embedded scene or an absolute path of a .toml file
  std::string preset;        ///< asked for; empty: the scene's own
  std::map<std::string, ParameterValue> loop_overrides;
  std::map<std::string, ParameterValue> motion_overrides = {};
  std::map<std::string, ParameterValue> mesh_overrides = {};
  std::string scene_sha256;  ///< of the resolved scene
  std::string backend;       ///< which the run was made with
  std::string build;         ///< of the program that recorded
  int nodes = 0;             ///< of all muscles
  int muscles = 1;
  bool muscle_contact = false;  ///< muscles touch: steps have `muscle_positions`
  int bones = 0;
  int substeps = 0;
  int iterations = 0;              ///< a substep
  double rounding_m = 0;           ///< see rounding_step_m
  std::vector<double> angles_deg;  ///< one a frame
  std::vector<int> free_nodes;     ///< those that collide, ascending

  [[nodiscard]] int frames() const { return static_cast<int>(angles_deg.size()); }
  [[nodiscard]] int steps_per_frame() const { return substeps * iterations; }
};

/// What one collision step of the loop worked on: world frame, metres, one position a node.
struct RecordedStep {
  std::vector<Vec3> substep_start;               ///< x
  std::vector<RigidMotion> previous_bone_poses;  ///< the poses that x was computed with
  std::vector<Vec3> positions;                   ///< p, which a backend is asked about
  std::vector<RigidMotion> bone_poses;
  /// What contact between muscles is asked about: before any contact stage has moved a node; empty where none touch.
  std::vector<Vec3> muscle_positions = {};
};

/// What identifies a recording on the disk.
struct RecordingFile {
  std::string sha256;
  std::uintmax_t bytes = 0;
};

/// The power of two, in metres, that positions of a scene of this size are rounded to: between 2^-33 and 2^-32 of the
/// diagonal, 0.1 nm for a hip. Rounding is a part of the input, the same for every backend, and no error of any.
double rounding_step_m(double scene_diagonal_m);

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/recording/recording.hpp"

namespace musclebench {

/// How far the muscle moved within the last steps, and from that where it will be: what writer and reader share.
///
/// Coordinates are whole multiples of the rounding step. The start of a substep is where the step before ended, but for
/// the nodes that its response moved. From there to the positions of a step is a displacement, which is extrapolated
/// from those of the same iteration in the last two substeps.
class StepPredictor {
 public:
  /// Two's complement: differences of whatever a file holds are defined.
  using Coordinates = std::vector<std::uint64_t>;

  /// Displacement extrapolated as nothing, constant or linear.
  static constexpr int orders = 3;

  StepPredictor(std::size_t coordinates, int iterations);

  /// Where the step before ended; at first the origin.
  [[nodiscard]] const Coordinates& last() const { return m_last; }
  /// Predicted positions of a step that begins at `from`.
  void predict(const Coordinates& from, int order, Coordinates& predicted) const;
  /// Tells where the step went.
  void advance(const Coordinates& from, const Coordinates& positions);

 private:
  std::size_t m_lag;  // steps from an iteration to the same one of the next substep
  Coordinates m_last;
  std::deque<Coordinates> m_displacements;  // the last 2 m_lag steps, oldest first
};

/// Turns collision steps into bytes, one after the other. Positions are rounded to `header.rounding_m`.
class StepEncoder {
 public:
  explicit StepEncoder(const RecordingHeader& header);

  /// Appends the next step to `bytes`; `muscle_positions` (of all nodes) where the header has muscles that touch.
  /// False, with nothing appended, when a position is not finite or too far away to be rounded (2^52 rounding steps).
  bool encode(std::span<const Vec3> substep_start, std::span<const RigidMotion> previous_bone_poses,
              std::span<const Vec3> positions, std::span<const RigidMotion> bone_poses, std::string& bytes,
              std::span<const Vec3> muscle_positions = {});

 private:
  bool round(std::span<const Vec3> points, StepPredictor::Coordinates& rounded) const;
  int best_order(const StepPredictor::Coordinates& from, const StepPredictor::Coordinates& positions);

  double m_steps_per_m;
  int m_iterations;
  bool m_muscle_contact;
  long m_steps = 0;
  StepPredictor m_predictor;
  // Scratch memory.
  StepPredictor::Coordinates m_start;
  StepPredictor::Coordinates m_positions;
  StepPredictor::Coordinates m_predicted;
  StepPredictor::Coordinates m_muscle_positions;
};

/// Inverse of `StepEncoder`.
class StepDecoder {
 public:
  explicit StepDecoder(const RecordingHeader& header);

  /// Takes the next step from the front of `bytes`. False when they are not what an encoder wrote.
  bool decode(std::string_view& bytes, RecordedStep& step);

 private:
  void to_metres(const StepPredictor::Coordinates& coordinates, std::vector<Vec3>& points) const;

  double m_rounding_m;
  int m_iterations;
  bool m_muscle_contact;
  std::size_t m_bones;
  long m_steps = 0;
  StepPredictor m_predictor;
  StepPredictor::Coordinates m_start;
  StepPredictor::Coordinates m_positions;
  StepPredictor::Coordinates m_predicted;
  StepPredictor::Coordinates m_muscle_positions;
  std::vector<RigidMotion> m_previous_poses;
  std::vector<RigidMotion> m_poses;
};

}  // namespace musclebench

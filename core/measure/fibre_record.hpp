#pragma once

#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "core/base/column.hpp"
#include "core/fibres/moment_arm.hpp"

namespace musclebench {

/// What a frame left of the fibres of one muscle.
struct FibreRecord {
  std::vector<double> lengths_m;       ///< by fibre
  std::optional<double> inside_share;  ///< of their points, truly inside a bone; nothing: not judged
};

/// The fibres of all muscles at the end of a frame; 0 is at rest.
struct FibreFrame {
  int frame = 0;
  double angle_rad = 0;  ///< of the bone that turns
  std::vector<FibreRecord> muscles;
};

/// Of one muscle in one frame: a row of fibres.csv.
struct FibreRow {
  int frame = 0;
  double angle_rad = 0;
  std::string muscle;
  std::vector<double> lengths_m;          ///< ascending
  std::vector<double> arms_m;             ///< ascending; none where there is no moment arm
  std::optional<MomentArm> of_mean = {};  ///< of the mean length
  std::optional<double> inside_share = {};
  double max_stretch = 0;  ///< of a fibre, over its length at rest
};

/// Of one fibre in one frame: a row of fibre_lengths.csv.
struct FibreLengthRow {
  int frame = 0;
  double angle_rad = 0;
  std::string muscle;
  int fibre = 0;  ///< from 1
  double length_m = 0;
  std::optional<MomentArm> arm = {};
};

/// The columns of a run's fibres.csv and fibre_lengths.csv.
std::span<const Column<FibreRow>> fibre_columns();
std::span<const Column<FibreLengthRow>> fibre_length_columns();

/// Rows of both, frame after frame, with the moment arms that follow from all of them. `names` of the muscles.
struct FibreTables {
  std::vector<FibreRow> muscles;
  std::vector<FibreLengthRow> fibres;
};
FibreTables fibre_tables(std::span<const std::string> names, std::span<const FibreFrame> frames);

/// A sentence for each muscle whose fibres, which nothing activates, are on average shorter than at rest, by more
/// than 0.1 %, in some frames: there they may be slack, and the slope of their length is the moment arm of a taut fibre
/// only.
std::vector<std::string> slack_notes(std::span<const std::string> names, std::span<const FibreFrame> frames);

}  // namespace musclebench

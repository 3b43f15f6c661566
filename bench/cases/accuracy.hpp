#pragma once

#include <optional>

#include "core/measure/answer_error.hpp"
#include "core/measure/depth_error.hpp"

namespace musclebench {

/// Errors of a frame's answers, or of all, by the Referee.
struct Accuracy {
  long contacts = 0;
  long true_contacts = 0;
  long missed_contacts = 0;
  long false_contacts = 0;
  long measured_contacts = 0;
  std::optional<ErrorStatistics> depth_error_m;     ///< nothing where no contact was measured
  std::optional<ErrorStatistics> normal_error_deg;  ///< nothing where no normal was
  double max_missed_depth_m = 0;
  double max_false_distance_m = 0;
};

Accuracy accuracy_of(const AnswerErrors& errors);

}  // namespace musclebench

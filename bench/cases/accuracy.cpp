#include "bench/cases/accuracy.hpp"

#include <vector>

namespace musclebench {

namespace {

std::optional<ErrorStatistics> statistics_of(const std::vector<double>& errors) {
  return errors.empty() ? std::nullopt : std::optional(error_statistics(errors));
}

}  // namespace

Accuracy accuracy_of(const AnswerErrors& errors) {
  return {errors.contacts,
          errors.true_contacts,
          errors.missed_contacts,
          errors.false_contacts,
          static_cast<long>(errors.depth_errors_m.size()),
          statistics_of(errors.depth_errors_m),
          statistics_of(errors.normal_errors_deg),
          errors.max_missed_depth_m,
          errors.max_false_distance_m};
}

}  // namespace musclebench

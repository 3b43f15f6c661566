#pragma once

#include <vector>

#include "core/base/parameters.hpp"

namespace musclebench {

/// How active a muscle is over a run: from `start_s` on it rises, holds and falls.
class ActivationCourse {
 public:
  explicit ActivationCourse(const Parameters& parameters);

  /// 0 to `level`; `time_s`: from the start of the run.
  [[nodiscard]] double at(double time_s) const;

 private:
  double m_level, m_start_s, m_rise_s, m_hold_s, m_fall_s;
};

/// `level`, then the times of the course.
ParameterSpec activation_level_parameter();
std::vector<ParameterSpec> activation_time_parameters();

}  // namespace musclebench

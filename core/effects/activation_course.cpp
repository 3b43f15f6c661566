#include "core/effects/activation_course.hpp"

#include <algorithm>

namespace musclebench {

ActivationCourse::ActivationCourse(const Parameters& parameters)
    : m_level(parameters.number("level")),
      m_start_s(parameters.number("start_s")),
      m_rise_s(parameters.number("rise_s")),
      m_hold_s(parameters.number("hold_s")),
      m_fall_s(parameters.number("fall_s")) {}

double ActivationCourse::at(double time_s) const {
  const auto share = [](double passed_s, double of_s) {
    return of_s > 0 ? std::clamp(passed_s / of_s, 0.0, 1.0) : (passed_s >= 0 ? 1.0 : 0.0);
  };
  const double rising_s = time_s - m_start_s;
  return m_level * (share(rising_s, m_rise_s) - share(rising_s - m_rise_s - m_hold_s, m_fall_s));
}

ParameterSpec activation_level_parameter() {
  return parameter::number({.name = "level",
                            .default_value = 1,
                            .minimum = 0,
                            .maximum = 1,
                            .help = "level of the activation after its rise"});
}

std::vector<ParameterSpec> activation_time_parameters() {
  constexpr double longest_s = 1e6;
  const auto seconds = [](const char* name, double by_default, const char* help) {
    return parameter::number(
        {.name = name, .unit = "s", .default_value = by_default, .minimum = 0, .maximum = longest_s, .help = help});
  };
  return {seconds("start_s", 0, "time at which the activation begins to rise, from the start of the run"),
          seconds("rise_s", 0.1, "duration of the rise"), seconds("hold_s", longest_s, "duration at the full level"),
          seconds("fall_s", 0.1, "duration of the fall")};
}

}  // namespace musclebench

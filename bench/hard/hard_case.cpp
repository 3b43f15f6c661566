#include "bench/hard/hard_case.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace musclebench {

namespace {

/// 1: at its bar. A bar of 0 is for counts.
double share_of_bar(const HardFigure& figure) {
  if (std::isnan(figure.value)) return std::numeric_limits<double>::infinity();
  if (figure.bar > 0) return figure.value / figure.bar;
  return figure.value > 0 ? 1 + figure.value : 0;
}

}  // namespace

std::string_view name_of(Verdict verdict) {
  static constexpr std::array<std::string_view, 4> names = {"holds", "breaks", "refused", "not applicable"};
  return names[static_cast<std::size_t>(verdict)];
}

const HardFigure* worst_figure(const HardCell& cell) {
  const auto worst = std::max_element(
      cell.figures.begin(), cell.figures.end(),
      [](const HardFigure& one, const HardFigure& other) { return share_of_bar(one) < share_of_bar(other); });
  return worst == cell.figures.end() ? nullptr : &*worst;
}

Parameters HardRequest::parameters(const std::map<std::string, ParameterValue>& more) const {
  std::map<std::string, ParameterValue> all = more;
  all.insert(given.begin(), given.end());
  return {backend.parameters, all, "--param"};
}

Parameters HardRequest::parameters_for_points(const std::map<std::string, ParameterValue>& more) const {
  std::map<std::string, ParameterValue> all = more;
  all.insert(given.begin(), given.end());
  all.insert(backend.for_points.begin(), backend.for_points.end());
  return {backend.parameters, all, "--param"};
}

HardCell judged(std::vector<HardFigure> figures, const HardRequest& request, const std::string& said,
                MayRefuse may_refuse) {
  const bool holds = std::ranges::all_of(figures, &HardFigure::holds);
  const bool may =
      may_refuse == MayRefuse::everybody || (may_refuse == MayRefuse::approximate && !request.backend.exact);
  const Verdict verdict = holds ? Verdict::holds : !said.empty() && may ? Verdict::refused : Verdict::breaks;
  return {verdict, said, std::move(figures)};
}

std::vector<HardCase> hard_cases() {
  std::vector<HardCase> all;
  for (const std::span<const HardCase> part :
       {point_cases(), input_cases(), motion_cases(), course_cases(), loop_cases(), limit_cases(), anatomy_cases(),
        load_cases(), muscle_load_cases(), passage_cases(), effect_cases(), tendon_cases()}) {
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

HardCell not_applicable(std::string why) { return {Verdict::not_applicable, std::move(why), {}}; }

}  // namespace musclebench

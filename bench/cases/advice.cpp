#include "bench/cases/advice.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/base/machine_state.hpp"

namespace musclebench {

namespace {

/// A predicted resolution is taken a little finer than the fitted order asks for: the order is a fit.
constexpr double prediction_margin = 1.1;
/// Less than this between two resolutions is not worth another build.
constexpr double worthwhile_step = 0.85;
/// Configurations are timed minutes apart: a machine drifts by so much meanwhile, which no interval knows of.
constexpr double drift = 1.1;
/// An error up to so much above the wanted one may be one of the few frames that were asked.
constexpr double nearly_held = 1.5;
/// The rest of the time is for trials.
constexpr double measuring_share = 0.5;

class Search {
 public:
  Search(const AdviceRequest& request, const Assess& assess, const Try& try_out)
      : m_request(request), m_assess(assess), m_try(try_out) {}

  Advice run() {
    for (const AdvisePlan& plan : m_request.plans) {
      if (plan.unit_of_price) {
        try_one({plan.backend, *plan.unit_of_price});
        m_advice.unit_of_price = Configuration{plan.backend, *plan.unit_of_price};
      }
    }
    // What is exact holds any depth, so whatever time there is, there is an answer.
    for (const bool exact : {true, false}) {
      for (const AdvisePlan& plan : m_request.plans) {
        if (plan.exact == exact) {
          try_all(plan);
        }
      }
    }
    choose();
    return std::move(m_advice);
  }

 private:
  [[nodiscard]] double spent_s() const { return static_cast<double>(process_cpu_ns() - m_start_ns) * 1e-9; }
  [[nodiscard]] bool holds(const Assessment& assessment) const { return assessment.error_m <= m_request.wanted_m; }

  std::optional<std::size_t> try_one(const Configuration& configuration, double predicted_s = 0) {
    for (std::size_t i = 0; i < m_advice.measured.size(); ++i) {
      if (m_advice.measured[i].configuration.text() == configuration.text()) {
        return i;
      }
    }
    const double left_s = (m_is_trying ? 1 : measuring_share) * m_request.seconds - spent_s();
    if (left_s <= 0 || predicted_s > left_s) {
      const std::string left = fmt::format("{:.0f} s are left", std::max(0.0, left_s));
      m_advice.omitted.push_back(
          {configuration, predicted_s > 0 ? fmt::format("would take about {:.0f} s; {}", predicted_s, left) : left});
      return std::nullopt;
    }
    std::string reason;
    const double before_s = spent_s();
    std::optional<Assessment> assessment = m_assess(configuration, reason);
    m_last_s = spent_s() - before_s;
    if (!assessment) {
      m_advice.omitted.push_back({configuration, reason});
      return std::nullopt;
    }
    m_advice.measured.push_back(*std::move(assessment));
    return m_advice.measured.size() - 1;
  }

  void try_all(const AdvisePlan& plan) {
    for (const Settings& point : plan.points) {
      try_one({plan.backend, point});
    }
    if (plan.refine) {
      const std::vector<std::size_t> steps = refine(plan.backend, *plan.refine);
      if (plan.refine->interpolate) {
        interpolate(plan.backend, *plan.refine, steps);
      }
    }
    if (plan.wanted_error) {
      adapt(plan.backend, *plan.wanted_error);
    }
  }

  static Configuration with_value(const std::string& backend, const Refinement& of, double value) {
    return of.is_integer ? Configuration{backend, {{of.parameter, static_cast<std::int64_t>(std::ceil(value))}}}
                         : Configuration{backend, {{of.parameter, typeable(value)}}};
  }

  /// Three digits: the number is to be typed.
  static double typeable(double value) { return std::stod(fmt::format("{:.3g}", value)); }

  /// Cells along an axis, or what is proportional to them: finer is more.
  static double fineness(const Refinement& of, double value) { return of.factor > 1 ? value : 1 / value; }

  [[nodiscard]] double fineness(const Refinement& of, const Assessment& of_step) const {
    const ParameterValue& value = of_step.configuration.parameters.at(of.parameter);
    const auto* whole = std::get_if<std::int64_t>(&value);
    return fineness(of, whole != nullptr ? static_cast<double>(*whole) : std::get<double>(value));
  }

  /// Step by step until the wanted depth holds; what was measured.
  std::vector<std::size_t> refine(const std::string& backend, const Refinement& of) {
    std::vector<std::size_t> measured;
    double predicted_s = 0;
    const double finest = fineness(of, of.to);
    for (double value = of.from; fineness(of, value) <= finest; value *= of.factor) {
      const std::optional<std::size_t> index = try_one(with_value(backend, of, value), predicted_s);
      if (!index) {
        break;
      }
      measured.push_back(*index);
      if (holds(m_advice.measured[*index])) {
        break;
      }
      const double build_s = static_cast<double>(m_advice.measured[*index].build_ns) * 1e-9;
      // More cells along each of three axes.
      const double more = std::pow(std::max(of.factor, 1 / of.factor), 3);
      predicted_s = std::max(0.0, m_last_s - build_s) + more * build_s;
    }
    return measured;
  }

  /// Between the last two steps, of which the finer holds and the coarser does not, or past the last that could be
  /// built.
  void interpolate(const std::string& backend, const Refinement& of, const std::vector<std::size_t>& steps) {
    if (steps.size() < 2) {
      return;
    }
    const Assessment coarse = m_advice.measured[steps[steps.size() - 2]];
    const Assessment fine = m_advice.measured[steps.back()];
    const double at_coarse = fineness(of, coarse);
    const double at_fine = fineness(of, fine);
    if (fine.error_m <= 0 || fine.error_m >= coarse.error_m || m_request.wanted_m <= 0) {
      return;
    }
    const double order = std::log(coarse.error_m / fine.error_m) / std::log(at_fine / at_coarse);
    const double wanted = prediction_margin * at_fine * std::pow(fine.error_m / m_request.wanted_m, 1 / order);
    const bool finer_is_known = holds(fine);
    if (finer_is_known ? wanted > worthwhile_step * at_fine : !(wanted < 2 * fineness(of, of.to))) {
      return;
    }
    const double build_s = static_cast<double>(fine.build_ns) * 1e-9 * std::pow(wanted / at_fine, 3);
    try_one(with_value(backend, of, fineness(of, wanted)), build_s);
  }

  /// Coarse ones first: what they cost to build says whether there is time for the fine one.
  void adapt(const std::string& backend, const WantedErrorSteps& of) {
    if (!(m_request.wanted_m > 0)) {
      return;
    }
    double error_m = std::min(m_request.wanted_m, of.coarsest_m);
    while (error_m * of.factor <= of.coarsest_m) {
      error_m *= of.factor;
    }
    double predicted_s = m_last_s;  // of what was tried before
    for (;;) {
      const Configuration adaptive{backend, {{of.parameter, typeable(error_m * of.per_metre)}}};
      const std::optional<std::size_t> index = try_one(adaptive, predicted_s);
      if (!index) {
        return;
      }
      const Assessment& measured = m_advice.measured[*index];
      const bool is_last = error_m <= m_request.wanted_m;
      if (holds(measured) || error_m < m_request.wanted_m) {
        return;
      }
      // The wanted error is that of all points near the surface; of this scene's contacts it may be a little more.
      const double finer_m = is_last ? m_request.wanted_m * m_request.wanted_m / (prediction_margin * measured.error_m)
                                     : std::max(m_request.wanted_m, error_m / of.factor);
      const double build_s = static_cast<double>(measured.build_ns) * 1e-9;
      predicted_s = std::max(0.0, m_last_s - build_s) + build_s * std::pow(error_m / finer_m, of.build_order);
      error_m = finer_m;
    }
  }

  void choose() {
    m_is_trying = true;
    for (;;) {
      const std::optional<std::size_t> next = cheapest_untried();
      if (!next) break;
      if (!try_and_judge(*next)) {
        m_advice.untried = next;
        break;
      }
      if (m_advice.measured[*next].refusal.empty()) {
        m_advice.chosen = next;
        break;
      }
      make_finer(Configuration(m_advice.measured[*next].configuration));
    }
    const auto by_error = [](const Assessment& a, const Assessment& b) { return a.error_m < b.error_m; };
    const auto best = std::ranges::min_element(m_advice.measured, by_error);
    if (best != m_advice.measured.end()) m_advice.best = static_cast<std::size_t>(best - m_advice.measured.begin());
  }

  /// Of those that promise to hold and were not tried.
  std::optional<std::size_t> cheapest_untried() {
    const auto& measured = m_advice.measured;
    const auto is_open = [&](std::size_t i) { return holds(measured[i]) && measured[i].refusal.empty(); };
    std::optional<std::size_t> fastest;
    for (std::size_t i = 0; i < measured.size(); ++i) {
      if (is_open(i) && (!fastest || measured[i].collision_ns.median < measured[*fastest].collision_ns.median)) {
        fastest = i;
      }
    }
    m_advice.fastest = fastest;
    std::optional<std::size_t> chosen = fastest;
    for (std::size_t i = 0; fastest && i < measured.size(); ++i) {
      if (is_open(i) && is_as_fast(measured[i].collision_ns, measured[*fastest].collision_ns) &&
          measured[i].structure_bytes < measured[*chosen].structure_bytes) {
        chosen = i;
      }
    }
    return chosen;
  }

  std::optional<Trial> trial_of(const Configuration& configuration) {
    const double left_s = m_request.seconds - spent_s();
    return left_s > 0 ? m_try(configuration, left_s) : std::nullopt;
  }

  /// Whether there was time.
  bool try_and_judge(std::size_t row) {
    if (!m_advice.measured[row].trial) m_advice.measured[row].trial = trial_of(m_advice.measured[row].configuration);
    if (!m_advice.measured[row].trial) return false;
    m_advice.measured[row].refusal = why_refused(m_advice.measured[row]);
    return true;
  }

  std::string why_refused(const Assessment& row) {
    const Trial& trial = *row.trial;
    if (trial.status == "diverged") return "its run diverges: " + trial.status_detail;
    if (m_request.bounds_depth && !(trial.node_depth_m <= m_request.wanted_m)) {
      return fmt::format("its run leaves nodes {:.3g} mm deep", trial.node_depth_m * 1e3);
    }
    if (trial.status == "ok" && trial.tunnelled_nodes == 0) return "";
    const Trial exact = exact_trial(row);
    if (trial.tunnelled_nodes > exact.tunnelled_nodes) {
      return fmt::format("in its run {} nodes tunnel", trial.tunnelled_nodes);
    }
    return trial.status != "ok" && exact.status == "ok" ? "its run is " + trial.status + ": " + trial.status_detail
                                                        : "";
  }

  /// What the exact backend's own run finds on the scene; without time for that nothing wrong.
  Trial exact_trial(const Assessment& row) {
    const auto exact = std::ranges::find_if(m_request.plans, &AdvisePlan::exact);
    if (exact == m_request.plans.end()) return {};
    const Configuration configuration{exact->backend, exact->points.empty() ? Settings{} : exact->points.front()};
    if (configuration.text() == row.configuration.text()) return *row.trial;
    if (!m_exact) m_exact = trial_of(configuration);
    return m_exact->value_or(Trial{});
  }

  /// Measures the next finer step of a structure whose trial did not hold, where there is one.
  void make_finer(const Configuration& refused) {
    const auto plan = std::ranges::find(m_request.plans, refused.backend, &AdvisePlan::backend);
    if (plan->refine && refused.parameters.contains(plan->refine->parameter)) {
      const Refinement& of = *plan->refine;
      const ParameterValue& value = refused.parameters.at(of.parameter);
      const auto* whole = std::get_if<std::int64_t>(&value);
      const double finer = of.factor * (whole != nullptr ? static_cast<double>(*whole) : std::get<double>(value));
      if (fineness(of, finer) <= fineness(of, of.to)) try_one(with_value(refused.backend, of, finer));
    } else if (plan->wanted_error && refused.parameters.contains(plan->wanted_error->parameter)) {
      const auto& of = *plan->wanted_error;
      try_one({refused.backend, {{of.parameter, typeable(std::get<double>(refused.parameters.at(of.parameter)) / 2)}}});
    }
  }

  static bool is_as_fast(const MedianEstimate& time, const MedianEstimate& fastest) {
    return time.low <= fastest.high || time.median <= drift * fastest.median;
  }

  const AdviceRequest& m_request;
  const Assess& m_assess;
  const Try& m_try;
  Advice m_advice;
  bool m_is_trying = false;
  std::optional<std::optional<Trial>> m_exact;  ///< asked for; nothing: there was no time
  Nanoseconds m_start_ns = process_cpu_ns();
  double m_last_s = 0;  ///< the last assessment took
};

double megabytes(const Assessment& assessment) { return static_cast<double>(assessment.structure_bytes) * 1e-6; }

std::string why_chosen(const Assessment& chosen, const Assessment& fastest) {
  if (&chosen == &fastest) {
    return "It is the fastest configuration that holds the error, and no equally fast configuration is smaller.";
  }
  return fmt::format(
      "It is smaller than {} ({:.3g} against {:.3g} MB) and about as fast: {:.3g} times its time. Overlapping "
      "intervals, or {:.0f} % between two measurements, count as equally fast.",
      fastest.configuration.text(), megabytes(chosen), megabytes(fastest),
      chosen.collision_ns.median / fastest.collision_ns.median, (drift - 1) * 100);
}

}  // namespace

std::vector<std::string> explain(const Advice& advice, const AdviceRequest& request, const AskedFrames& frames) {
  std::vector<std::string> lines;
  if (advice.chosen) {
    lines.push_back(why_chosen(advice.measured[*advice.chosen], advice.measured[*advice.fastest]));
  }
  for (const Assessment& row : advice.measured) {
    const bool nearly = row.error_m > request.wanted_m && row.error_m <= nearly_held * request.wanted_m;
    const bool cheaper = !advice.chosen ||
                         row.collision_ns.median < advice.measured[*advice.chosen].collision_ns.median ||
                         row.structure_bytes < advice.measured[*advice.chosen].structure_bytes;
    if (nearly && cheaper && frames.asked < frames.all) {
      lines.push_back(fmt::format(
          "{} would be cheaper and misses the error narrowly ({:.3g} mm), by {} of {} frames. Over all frames its "
          "error may differ.",
          row.configuration.text(), row.error_m * 1e3, frames.asked, frames.all));
    }
  }
  return lines;
}

std::string Configuration::text() const {
  std::string text = backend;
  for (const auto& [name, value] : parameters) {
    text += fmt::format(" {}={}", name, format_parameter_value(value));
  }
  return text;
}

Advice find_advice(const AdviceRequest& request, const Assess& assess, const Try& try_out) {
  return Search(request, assess, try_out).run();
}

}  // namespace musclebench

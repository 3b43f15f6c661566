#include "bench/cases/advice.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace musclebench {

namespace {

constexpr std::int64_t coarsest_field = 8;
constexpr std::int64_t finest_field = 256;
constexpr std::int64_t coarsest_voxels = 16;
constexpr std::int64_t finest_voxels = 256;
/// What times are compared with, so always measured.
constexpr std::int64_t unit_of_price = 64;
/// Adaptive fields get finer by this factor until they are as fine as wanted, from about a millimetre on.
constexpr double adaptive_step = 4;
constexpr double coarsest_adaptive_m = 1e-3;
/// A little steeper than what building one cost over its wanted error on scanned bones.
constexpr double adaptive_build_order = 1.6;
/// A predicted resolution is taken a little finer than the fitted order asks for: the order is a fit.
constexpr double prediction_margin = 1.1;
/// Less than this between two resolutions is not worth another build.
constexpr double worthwhile_step = 0.85;

class Search {
 public:
  Search(const AdviceRequest& request, const Assess& assess) : m_request(request), m_assess(assess) {}

  Advice run() {
    try_one(with_cells("voxel", unit_of_price));
    try_one({"bvh", {}});
    refine("voxel", coarsest_voxels, finest_voxels);
    const std::vector<std::size_t> fields = refine("sdf", coarsest_field, finest_field);
    interpolate(fields);
    adapt();
    if (m_request.with_fcl) {
      try_one({"fcl", {}});
      try_one({"fcl", {{"bounding_volume", std::string("OBB")}}});
    }
    choose();
    return std::move(m_advice);
  }

 private:
  [[nodiscard]] double spent_s() const { return static_cast<double>(monotonic_now_ns() - m_start_ns) * 1e-9; }
  [[nodiscard]] bool holds(const Assessment& assessment) const { return assessment.p99_error_m <= m_request.depth_m; }

  std::optional<std::size_t> try_one(const Configuration& configuration, double predicted_s = 0) {
    for (std::size_t i = 0; i < m_advice.measured.size(); ++i) {
      if (m_advice.measured[i].configuration.text() == configuration.text()) {
        return i;
      }
    }
    const double left_s = m_request.seconds - spent_s();
    if (left_s <= 0 || predicted_s > left_s) {
      const std::string left = fmt::format("{:.0f} s are left", std::max(0.0, left_s));
      m_advice.omitted.push_back(
          {configuration, predicted_s > 0 ? fmt::format("would take about {:.0f} s; {}", predicted_s, left) : left});
      return std::nullopt;
    }
    std::string reason;
    const Nanoseconds start_ns = monotonic_now_ns();
    std::optional<Assessment> assessment = m_assess(configuration, reason);
    m_last_s = static_cast<double>(monotonic_now_ns() - start_ns) * 1e-9;
    if (!assessment) {
      m_advice.omitted.push_back({configuration, reason});
      return std::nullopt;
    }
    m_advice.measured.push_back(*std::move(assessment));
    return m_advice.measured.size() - 1;
  }

  static Configuration with_cells(const std::string& backend, std::int64_t cells) {
    return {backend, {{"cells", cells}}};
  }

  /// Doubles the cells until the wanted depth holds; where they were measured.
  std::vector<std::size_t> refine(const std::string& backend, std::int64_t coarsest, std::int64_t finest) {
    std::vector<std::size_t> places;
    double predicted_s = 0;
    for (std::int64_t cells = coarsest; cells <= finest; cells *= 2) {
      const std::optional<std::size_t> place = try_one(with_cells(backend, cells), predicted_s);
      if (!place) {
        break;
      }
      places.push_back(*place);
      if (holds(m_advice.measured[*place])) {
        break;
      }
      const double build_s = static_cast<double>(m_advice.measured[*place].build_ns) * 1e-9;
      predicted_s = std::max(0.0, m_last_s - build_s) + 8 * build_s;  // twice the cells along each of three axes
    }
    return places;
  }

  /// Between the last two resolutions, of which the finer holds and the coarser does not, or past the last that could
  /// be built.
  void interpolate(const std::vector<std::size_t>& places) {
    if (places.size() < 2) {
      return;
    }
    const Assessment coarse = m_advice.measured[places[places.size() - 2]];
    const Assessment fine = m_advice.measured[places.back()];
    const double coarse_cells =
        static_cast<double>(std::get<std::int64_t>(coarse.configuration.parameters.at("cells")));
    const double fine_cells = static_cast<double>(std::get<std::int64_t>(fine.configuration.parameters.at("cells")));
    if (fine.p99_error_m <= 0 || fine.p99_error_m >= coarse.p99_error_m || m_request.depth_m <= 0) {
      return;
    }
    const double order = std::log(coarse.p99_error_m / fine.p99_error_m) / std::log(fine_cells / coarse_cells);
    const double wanted = prediction_margin * fine_cells * std::pow(fine.p99_error_m / m_request.depth_m, 1 / order);
    const bool finer_is_known = holds(fine);
    if (finer_is_known ? wanted > worthwhile_step * fine_cells : !(wanted < static_cast<double>(2 * finest_field))) {
      return;
    }
    const auto cells = static_cast<std::int64_t>(std::ceil(wanted));
    const double build_s = static_cast<double>(fine.build_ns) * 1e-9 * std::pow(wanted / fine_cells, 3);
    try_one(with_cells("sdf", cells), build_s);
  }

  /// Coarse ones first: what they cost to build says whether there is time for the fine one.
  void adapt() {
    if (!(m_request.depth_m > 0)) {
      return;
    }
    double error_m = std::min(m_request.depth_m, coarsest_adaptive_m);
    while (error_m * adaptive_step <= coarsest_adaptive_m) {
      error_m *= adaptive_step;
    }
    double predicted_s = m_last_s;  // of a field of cubes
    for (;;) {
      const std::optional<std::size_t> place = try_one(adaptive(error_m), predicted_s);
      if (!place) {
        return;
      }
      const Assessment& measured = m_advice.measured[*place];
      const bool is_last = error_m <= m_request.depth_m;
      if (holds(measured) || error_m < m_request.depth_m) {
        return;
      }
      // The wanted error is that of all points near the surface; of this scene's contacts it may be a little more.
      const double finer_m = is_last
                                 ? m_request.depth_m * m_request.depth_m / (prediction_margin * measured.p99_error_m)
                                 : std::max(m_request.depth_m, error_m / adaptive_step);
      const double build_s = static_cast<double>(measured.build_ns) * 1e-9;
      predicted_s = std::max(0.0, m_last_s - build_s) + build_s * std::pow(error_m / finer_m, adaptive_build_order);
      error_m = finer_m;
    }
  }

  static Configuration adaptive(double error_m) {
    // Three digits: the number is to be typed.
    return {"sdf", {{"max_error_mm", std::stod(fmt::format("{:.3g}", error_m * 1e3))}}};
  }

  void choose() {
    const auto& measured = m_advice.measured;
    std::optional<std::size_t> fastest;
    for (std::size_t i = 0; i < measured.size(); ++i) {
      if (!m_advice.best || measured[i].p99_error_m < measured[*m_advice.best].p99_error_m) {
        m_advice.best = i;
      }
      if (holds(measured[i]) &&
          (!fastest || measured[i].collision_ns.median < measured[*fastest].collision_ns.median)) {
        fastest = i;
      }
    }
    m_advice.chosen = fastest;
    for (std::size_t i = 0; fastest && i < measured.size(); ++i) {
      const bool as_fast = measured[i].collision_ns.low <= measured[*fastest].collision_ns.high;
      if (holds(measured[i]) && as_fast && measured[i].structure_bytes < measured[*m_advice.chosen].structure_bytes) {
        m_advice.chosen = i;
      }
    }
  }

  const AdviceRequest& m_request;
  const Assess& m_assess;
  Advice m_advice;
  Nanoseconds m_start_ns = monotonic_now_ns();
  double m_last_s = 0;  ///< the last assessment took
};

}  // namespace

std::string Configuration::text() const {
  std::string text = backend;
  for (const auto& [name, value] : parameters) {
    text += fmt::format(" {}={}", name, format_parameter_value(value));
  }
  return text;
}

MedianInterval median_interval(std::vector<double> values) {
  assert(!values.empty());
  std::sort(values.begin(), values.end());
  const auto count = static_cast<double>(values.size());
  const std::size_t middle = values.size() / 2;
  const double median = values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
  if (values.size() < 6) {
    return {median, values.front(), values.back()};
  }
  // The number of values below the true median is binomial; 1.96 standard deviations about its mean.
  const double half = 0.98 * std::sqrt(count);
  const auto low = static_cast<std::size_t>(std::max(0.0, std::floor(0.5 * count - half)));
  const auto high = static_cast<std::size_t>(std::min(count - 1, std::ceil(0.5 * count + half - 1)));
  return {median, values[low], values[high]};
}

Advice find_advice(const AdviceRequest& request, const Assess& assess) { return Search(request, assess).run(); }

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/cases/advise_plan.hpp"
#include "core/base/scoped_timer.hpp"

namespace musclebench {

/// A backend with the parameters that differ from its defaults.
struct Configuration {
  std::string backend;
  Settings parameters;

  /// As one would type it: name, then key=value of each parameter.
  [[nodiscard]] std::string text() const;
};

/// A median with its 95 % interval.
struct MedianInterval {
  double median = 0;
  double low = 0;
  double high = 0;
};

/// The median of `values`, at least one, with the interval between order statistics that holds the true median in about
/// 95 of 100 samples of independent values (sign test, normal approximation; below 6 values the whole range).
MedianInterval median_interval(std::vector<double> values);

struct ContactCounts {
  long missed = 0;
  long wrong = 0;  ///< reported and not there
  long real = 0;
};

/// What a configuration was measured to cost and to err on one scene.
struct Assessment {
  Configuration configuration;
  double error_m = 0;  ///< what has to hold: see AdviceRequest
  double max_error_m = 0;
  std::optional<ContactCounts> contacts = {};  ///< of replayed frames
  MedianInterval collision_ns;                 ///< a frame
  Nanoseconds build_ns = 0;
  std::size_t structure_bytes = 0;
};

/// A configuration that was left out, and why.
struct Omission {
  Configuration configuration;
  std::string reason;
};

/// How the search measures: nothing where the configuration can't be built, with the reason put into the second.
using Assess = std::function<std::optional<Assessment>(const Configuration&, std::string& reason)>;

struct AdviceRequest {
  /// The largest Assessment::error_m that holds: of the depth error its 99th percentile over the contacts, of the
  /// moment arm its RMS over the motion.
  double wanted_m = 1e-4;
  double seconds = 90;  ///< for building and measuring; a configuration that would take longer is left out
  std::vector<AdvisePlan> plans = {};  ///< a backend each
};

struct Advice {
  std::vector<Assessment> measured;  ///< in the order of measuring
  std::vector<Omission> omitted;
  std::optional<Configuration> unit_of_price;
  std::optional<std::size_t> chosen;   ///< in `measured`; nothing when none holds
  std::optional<std::size_t> fastest;  ///< of those that hold
  std::optional<std::size_t> best;     ///< the smallest error; nothing when nothing could be measured
};

/// Measures what the plans name, the exact backends first: single configurations, resolutions from coarse to fine until
/// one holds, one between two of them that is predicted from the observed order, and structures that
/// adapt to a wanted error.
/// Chosen is the fastest that holds; of those as fast (intervals that overlap, or no more than a tenth slower) the one
/// with the least bytes.
Advice find_advice(const AdviceRequest& request, const Assess& assess);

/// How many frames of the run an advice rests on.
struct AskedFrames {
  int asked = 0;
  int all = 0;
};

/// Why the chosen one, and which cheaper ones were refused by an error that more frames might not have; a line each.
std::vector<std::string> explain(const Advice& advice, const AdviceRequest& request, const AskedFrames& frames);

}  // namespace musclebench

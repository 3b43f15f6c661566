#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/cases/advise_plan.hpp"
#include "core/base/scoped_timer.hpp"
#include "core/measure/block_bootstrap.hpp"

namespace musclebench {

/// A backend with the parameters that differ from its defaults.
struct Configuration {
  std::string backend;
  Settings parameters;

  /// As one would type it: name, then key=value of each parameter.
  [[nodiscard]] std::string text() const;
};

struct ContactCounts {
  long missed = 0;
  long wrong = 0;  ///< reported and not there
  long real = 0;
};

/// What was found when a configuration moved the muscle itself over the whole motion, by the Referee.
struct Trial {
  std::string status = "ok";
  std::string status_detail = {};
  int frames = 0;
  double node_depth_m = 0;  ///< of the deepest node in any frame
  std::optional<double> surface_depth_m = {};
  int tunnelled_nodes = 0;  ///< most at the end of one frame
  double frame_ns = 0;      ///< median
};

/// What a configuration was measured to cost and to err on one scene.
struct Assessment {
  Configuration configuration;
  double error_m = 0;  ///< what it promises: see AdviceRequest
  double max_error_m = 0;
  std::optional<ContactCounts> contacts = {};  ///< of replayed frames
  MedianEstimate collision_ns;                 ///< a frame
  Nanoseconds build_ns = 0;
  std::size_t structure_bytes = 0;
  std::optional<Trial> trial = {};  ///< nothing where it was not run
  std::string refusal = {};         ///< why its trial does not hold what it promises
};

/// A configuration that was left out, and why.
struct Omission {
  Configuration configuration;
  std::string reason;
};

/// How the search measures: nothing where the configuration can't be built, with the reason put into the second.
using Assess = std::function<std::optional<Assessment>(const Configuration&, std::string& reason)>;
/// Runs the configuration over the whole motion: nothing where that takes more CPU time than `seconds`.
using Try = std::function<std::optional<Trial>(const Configuration&, double seconds)>;

struct AdviceRequest {
  /// The largest Assessment::error_m that holds: of the surface offset its 99th percentile over the contacts, of the
  /// moment arm its RMS over the motion.
  double wanted_m = 1e-4;
  double seconds = 120;                ///< CPU time for building, measuring and trying
  std::vector<AdvisePlan> plans = {};  ///< a backend each
  bool bounds_depth = true;            ///< no node may be deeper than `wanted_m` in the trial
};

struct Advice {
  std::vector<Assessment> measured;  ///< in the order of measuring
  std::vector<Omission> omitted;
  std::optional<Configuration> unit_of_price;
  std::optional<std::size_t> chosen;   ///< in `measured`: it was tried, and held; nothing when none did
  std::optional<std::size_t> untried;  ///< the one that would have been tried next when the time was up
  std::optional<std::size_t> fastest;  ///< of those that hold
  std::optional<std::size_t> best;     ///< the smallest error; nothing when nothing could be measured
};

/// Measures in half of the time what the plans name, the exact backends first: single configurations, resolutions from
/// coarse to fine until one holds, one between two of them that is predicted from the observed order, and structures
/// that adapt to a wanted error. Then the cheapest that promises to hold is tried, and the next where it does not; a
/// resolution that does not is made finer. Cheapest is the fastest; of those as fast (intervals that overlap, or no
/// more than a tenth slower) the one with the least bytes. A trial holds where no node is too deep, and where it is no
/// worse than the exact backend's: as few tunnelled nodes, and `ok` where that is.
Advice find_advice(const AdviceRequest& request, const Assess& assess, const Try& try_out);

/// How many frames of the run an advice rests on.
struct AskedFrames {
  int asked = 0;
  int all = 0;
};

/// Why the chosen one, and which cheaper ones were refused by an error that more frames might not have; a line each.
std::vector<std::string> explain(const Advice& advice, const AdviceRequest& request, const AskedFrames& frames);

}  // namespace musclebench

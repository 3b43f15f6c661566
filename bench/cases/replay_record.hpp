#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/cases/accuracy.hpp"
#include "core/base/scoped_timer.hpp"

namespace musclebench {

struct ReplayedFrame {
  int frame = 0;  ///< 1-based, of the recording
  double angle_deg = 0;
  bool warm_up = false;
  int iterations = 0;             ///< collision steps
  long involuntary_switches = 0;  ///< while the frame was timed, see ContextSwitches
};

/// A muscle with a bone or with another muscle in one replayed frame; times and counts are sums over its collision
/// steps.
struct PairReplay {
  std::string muscle;
  std::string other;
  std::string backend;
  std::optional<Nanoseconds> detect_ns = {};  ///< queries of the pair's nodes, over all threads; nothing: not told
  /// What detects between these muscles, for all of its pairs and with following their surfaces; nothing with bones.
  std::optional<Nanoseconds> backend_ns = {};
  long contacts = 0;
  std::optional<Accuracy> accuracy = {};  ///< nothing where the Referee did not judge
};

/// One of several muscles with all bones.
struct MuscleAnswers {
  std::string muscle;
  long contacts = 0;                      ///< answered
  std::optional<Accuracy> accuracy = {};  ///< nothing where the Referee did not judge
};

/// One replayed frame; times and counts are sums over its collision steps.
struct ReplayRecord : ReplayedFrame {
  Nanoseconds update_ns = 0;
  Nanoseconds detect_ns = 0;
  Nanoseconds respond_ns = 0;
  long contacts = 0;
  std::optional<Accuracy> accuracy;    ///< nothing where the Referee did not judge
  std::vector<MuscleAnswers> muscles;  ///< empty where there is but one
  std::vector<PairReplay> pairs;       ///< bone after bone with each muscle; empty where there is but one

  [[nodiscard]] Nanoseconds collision_ns() const { return update_ns + detect_ns + respond_ns; }
};

/// What was asked between muscles in one replayed frame.
struct MuscleReplayRecord : ReplayedFrame {
  std::vector<PairReplay> pairs;  ///< in the order of the scene's
};

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/cases/accuracy.hpp"
#include "core/base/scoped_timer.hpp"
#include "core/contact/muscle_contact.hpp"

namespace musclebench {

struct ReplayCase;
class FrameSource;

/// One pair of muscles in one replayed frame; times and counts are sums over its collision steps.
struct PairReplay {
  MusclePair muscles;
  std::string backend;
  Nanoseconds detect_ns = 0;   ///< queries of the pair's nodes, summed over threads
  Nanoseconds backend_ns = 0;  ///< what detects this pair, for all of its pairs and with following their surfaces
  long contacts = 0;
  std::optional<Accuracy> accuracy = {};  ///< nothing where the Referee did not judge
};

/// One replayed frame.
struct MuscleReplayRecord {
  int frame = 0;  ///< 1-based, of the recording
  double angle_deg = 0;
  bool warm_up = false;
  int iterations = 0;             ///< collision steps
  long involuntary_switches = 0;  ///< while the frame was timed, see ContextSwitches
  std::vector<PairReplay> pairs;  ///< in the order of the scene's
};

/// What was asked and answered between muscles that touch.
struct MuscleReplay {
  std::vector<MuscleReplayRecord> records;
  std::vector<Accuracy> accuracy;  ///< by pair, over all frames; empty where the Referee did not judge
  std::string contact_hash;        ///< of all contacts of all steps, in their order, to the last bit
  bool deterministic = true;       ///< both passes got the same contacts
  std::size_t structure_bytes = 0;
  Nanoseconds build_ns = 0;
};

/// Feeds what contact between muscles was asked about to the backends of the case's pairs, twice as replay_case does:
/// timed, and judged by the MuscleReferee. Nothing is corrected. `report` is called after each frame of each pass.
MuscleReplay replay_muscles(const ReplayCase& replay, FrameSource& recording, const std::function<void()>& report);

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "bench/cases/replay_record.hpp"

namespace musclebench {

struct ReplayCase;
class FrameSource;

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

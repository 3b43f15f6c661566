#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "bench/cases/replay_case.hpp"
#include "core/base/column.hpp"

namespace musclebench {

/// Hash of the resolved case, the recording and the build.
std::string replay_id(const ReplayCase& replay);

/// One of several muscles in one replayed frame: a row of muscles.csv.
struct MuscleReplayRow {
  const ReplayedFrame& frame;
  const MuscleAnswers& answers;
};

/// One of several muscles and a bone, or two muscles that touch, in one replayed frame: a row of pairs.csv.
struct PairReplayRow {
  const ReplayedFrame& frame;
  const PairReplay& pair;
};

/// The columns of a replay's frames.csv.
std::span<const Column<ReplayRecord>> replay_columns();

/// The columns of its muscles.csv and pairs.csv, which are there where there are several muscles.
std::span<const Column<MuscleReplayRow>> replay_muscle_columns();
std::span<const Column<PairReplayRow>> replay_pair_columns();

/// Makes `folder` a result folder with run.json, frames.csv and, of several muscles, muscles.csv and pairs.csv.
/// `recording` is the file that was replayed. Throws InputError, with nothing left behind, when that fails.
void write_replay(const std::filesystem::path& folder, const ReplayCase& replay, const ReplayResult& result,
                  const RecordingHeader& header, const std::filesystem::path& recording);

}  // namespace musclebench

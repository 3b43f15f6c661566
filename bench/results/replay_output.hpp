#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "bench/cases/replay_case.hpp"
#include "core/base/column.hpp"

namespace musclebench {

/// Hash of the resolved case, the recording and the build.
std::string replay_id(const ReplayCase& replay);

/// Of one pair of muscles that touch in one replayed frame: a row of pairs.csv.
struct PairReplayRow {
  const MuscleReplayRecord& frame;
  const std::string& muscle;
  const std::string& other;
  const PairReplay& pair;
};

/// The columns of a replay's frames.csv.
std::span<const Column<ReplayRecord>> replay_columns();

/// The columns of its pairs.csv, which is there where contact between muscles was replayed, too.
std::span<const Column<PairReplayRow>> replay_pair_columns();

/// Makes `folder` a result folder with run.json, frames.csv and pairs.csv. `recording` is the file that was replayed.
/// Throws InputError, with nothing left behind, when that fails.
void write_replay(const std::filesystem::path& folder, const ReplayCase& replay, const ReplayResult& result,
                  const RecordingHeader& header, const std::filesystem::path& recording);

}  // namespace musclebench

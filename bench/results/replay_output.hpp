#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "bench/cases/replay_case.hpp"
#include "core/base/column.hpp"

namespace musclebench {

/// Hash of the resolved case, the recording and the build.
std::string replay_id(const ReplayCase& replay);

/// The columns of a replay's frames.csv.
std::span<const Column<ReplayRecord>> replay_columns();

/// Makes `folder` a result folder with run.json and frames.csv. `recording` is the file that was replayed. Throws
/// InputError, with nothing left behind, when that fails.
void write_replay(const std::filesystem::path& folder, const ReplayCase& replay, const ReplayResult& result,
                  const RecordingHeader& header, const std::filesystem::path& recording);

}  // namespace musclebench

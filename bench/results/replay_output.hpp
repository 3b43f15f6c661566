#pragma once

#include <filesystem>
#include <string>

#include "bench/cases/replay_case.hpp"

namespace musclebench {

/// Hash of the resolved case, the recording and the build.
std::string replay_id(const ReplayCase& replay);

/// Makes `folder` a result folder with run.json and frames.csv. `recording` is the file that was replayed. Throws
/// InputError, with nothing left behind, when that fails.
void write_replay(const std::filesystem::path& folder, const ReplayCase& replay, const ReplayResult& result,
                  const RecordingHeader& header, const std::filesystem::path& recording);

}  // namespace musclebench

#pragma once

#include <filesystem>
#include <string>

#include "bench/cases/run_case.hpp"

namespace musclebench {

/// Hash of the resolved case and the build: two runs with the same id do the same work.
std::string run_id(const RunCase& run);

/// Makes `folder` a result folder with run.json, frames.csv, and with snapshots the shapes and the bones. Throws
/// InputError, with nothing left behind, when that fails (a full disk, say).
void write_run(const std::filesystem::path& folder, const RunCase& run, const RunResult& result);

}  // namespace musclebench

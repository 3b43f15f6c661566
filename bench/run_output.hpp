#pragma once

#include <filesystem>
#include <string>

#include "bench/run_case.hpp"

namespace musclebench {

/// Hash of the resolved case and the build: two runs with the same id do the same work.
std::string run_id(const RunCase& run);

/// Whether `folder` holds the complete result of the run with this id.
bool is_complete(const std::filesystem::path& folder, const std::string& id);

/// Throws InputError when `folder` could not be made or written. Leaves nothing behind.
void require_writable(const std::filesystem::path& folder);

/// Writes run.json, frames.csv, and with snapshots the shapes and the bones, into a temporary folder beside `folder`,
/// which then takes its place. Throws InputError, with nothing left behind, when that fails (a full disk, say).
void write_run(const std::filesystem::path& folder, const RunCase& run, const RunResult& result);

}  // namespace musclebench

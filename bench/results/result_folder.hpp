#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "bench/results/manifest.hpp"

namespace musclebench {

/// The run.json of a folder; null where there is none or it is no regular file, discarded where it is no JSON.
Json read_manifest(const std::filesystem::path& folder);

/// How a result ended, as its run.json says.
struct StoredResult {
  std::string status;
  std::string status_detail;
};

/// The complete result with this id in `folder`: its run.json says `ok` or `suspect` and its table `rows_file` has all
/// rows that run.json tells of. Nothing where there is none.
std::optional<StoredResult> complete_result(const std::filesystem::path& folder, const std::string& id,
                                            std::string_view rows_file);
bool is_complete(const std::filesystem::path& folder, const std::string& id, std::string_view rows_file);

/// Throws InputError when `folder` could not be made or written, or holds something else than a result. Leaves nothing
/// behind.
void require_writable(const std::filesystem::path& folder);

/// Lets `write_files` fill a temporary folder beside `folder`, which then takes its place. Throws InputError, with
/// nothing left behind, when that fails (a full disk, say).
void write_result_folder(const std::filesystem::path& folder,
                         const std::function<void(const std::filesystem::path&)>& write_files);

}  // namespace musclebench

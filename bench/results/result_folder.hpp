#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace musclebench {

/// Whether `folder` holds a complete result with this id: its run.json says `ok` or `suspect` and its table `rows_file`
/// is there.
bool is_complete(const std::filesystem::path& folder, const std::string& id, std::string_view rows_file);

/// Throws InputError when `folder` could not be made or written, or holds something else than a result. Leaves nothing
/// behind.
void require_writable(const std::filesystem::path& folder);

/// Lets `write_files` fill a temporary folder beside `folder`, which then takes its place. Throws InputError, with
/// nothing left behind, when that fails (a full disk, say).
void write_result_folder(const std::filesystem::path& folder,
                         const std::function<void(const std::filesystem::path&)>& write_files);

}  // namespace musclebench

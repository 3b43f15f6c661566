#pragma once

#include <filesystem>
#include <functional>
#include <ostream>

namespace musclebench {

/// Writes a file under a temporary name first, so that a half-written one is never found under `path`; creates the
/// folder. Throws InputError (about the path) when that fails, and what `write` throws; then nothing is left behind,
/// and a file that was there before is as it was.
void write_atomically(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write);

}  // namespace musclebench

#pragma once

#include <filesystem>
#include <functional>
#include <ostream>

namespace musclebench {

/// Writes a file under a temporary name first, so that a half-written one is never found under `path`; creates the
/// folder. Throws InputError (place: the path) when that fails; nothing is left behind.
void write_atomically(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write);

}  // namespace musclebench

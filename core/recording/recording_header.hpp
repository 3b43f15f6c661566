#pragma once

#include <string>
#include <string_view>

#include "core/recording/recording.hpp"

namespace musclebench {

/// First line of a recording.
inline constexpr std::string_view recording_magic = "musclebench recording ";
inline constexpr std::string_view recording_version = "1\n";
/// What stands before the hash at the end of the file.
inline constexpr std::string_view recording_hash_mark = "sha256 ";
inline constexpr std::size_t recording_hash_digits = 64;

std::string text_of(const RecordingHeader& header);

/// Throws InputError that names `location` when the text lacks something or contradicts itself.
RecordingHeader header_of(std::string_view text, std::string_view location);

}  // namespace musclebench

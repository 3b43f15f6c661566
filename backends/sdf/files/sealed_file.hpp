#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <ostream>
#include <span>
#include <string>

namespace musclebench {

// What the files of built structures share: they begin with a name, a byte order and a version, are sealed by a digest
// of their content, are whole or not there, and are refused with what differs.

/// SHA-256 in hexadecimal, as it stands in a file.
using FileDigest = std::array<char, 64>;

FileDigest as_file_digest(const std::string& text);

/// The first bytes of a file, of this machine's byte order.
struct FileMark {
  std::array<char, 8> name{};
  std::uint32_t byte_order = 0x01020304;
  std::uint32_t version = 0;
};

/// What keeps a file that begins so from being read as one that should begin with `wanted`; empty: nothing. `kind`:
/// "a field file".
std::string first_difference(const FileMark& found, const FileMark& wanted, const std::string& kind);

/// Throws InputError (place: the path) with the reason and the cure.
[[noreturn]] void refuse_structure(const std::filesystem::path& path, const std::string& reason);

void write_bytes(std::ostream& out, std::span<const std::byte> bytes);

/// Writes a file under a temporary name first, so that a half-written one is never found under `path`; creates the
/// folder. Throws InputError (place: the path) when that fails; nothing is left behind.
void write_atomically(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write);

}  // namespace musclebench

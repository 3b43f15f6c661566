#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "core/base/atomic_file.hpp"
#include "core/base/sha256.hpp"

namespace musclebench {

// Common to the files of built structures: a header with name, byte order and version, a digest of the content, and
// errors that say what differs.

/// SHA-256 in hexadecimal, as it stands in a file.
using FileDigest = std::array<char, 64>;

FileDigest as_file_digest(const std::string& text);

/// The first bytes of a file, of this machine's byte order.
struct FileMark {
  std::array<char, 8> name{};
  std::uint32_t byte_order = 0x01020304;
  std::uint32_t version = 0;
};

/// Describes how the mark of a file differs from `wanted`, so that the file can't be read; empty: it does not. `kind`:
/// "a field file".
std::string first_difference(const FileMark& found, const FileMark& wanted, const std::string& kind);

/// Reads a file piece by piece and checks counts against the bytes left, so that a damaged count allocates no memory.
class BinaryReader {
 public:
  /// Texts of an error: the file ends too early, and the cure.
  struct Words {
    std::string truncated;
    std::string cure;
  };

  /// Throws InputError (about the path), as all of this class, where the path is not a regular file or can't be read.
  BinaryReader(const std::filesystem::path& path, Words words);

  [[noreturn]] void refuse(const std::string& reason) const;

  void read(std::span<std::byte> bytes);
  template <typename T>
  T read() {
    T value{};
    read(std::as_writable_bytes(std::span(&value, 1)));
    return value;
  }
  template <typename T>
  std::vector<T> read_all(std::uint64_t count) {
    require(count <= m_left / sizeof(T));
    std::vector<T> values(count);
    read(std::as_writable_bytes(std::span(values)));
    return values;
  }

  [[nodiscard]] std::uintmax_t bytes_left() const { return m_left; }
  void require_end() const;

 private:
  void require(bool is_there) const;

  std::filesystem::path m_path;
  Words m_words;
  std::ifstream m_in;
  std::uintmax_t m_left = 0;
};

/// The cure names the parameter `structures`.
BinaryReader::Words sealed_file_words();

/// Reads a sealed file: a `Header` that begins with a FileMark and has the member `content`, then the parts that the
/// caller asks for. Throws InputError (about the path) with what is wrong.
template <typename Header>
class SealedReader {
 public:
  explicit SealedReader(const std::filesystem::path& path) : m_in(path, sealed_file_words()) {
    if (m_in.bytes_left() < sizeof(Header)) {
      refuse("is too short for a field file");
    }
    m_header = m_in.read<Header>();
    Header hashed = m_header;
    hashed.content.fill('\0');
    m_hash.add(std::as_bytes(std::span(&hashed, 1)));
  }

  [[nodiscard]] const Header& header() const { return m_header; }
  [[noreturn]] void refuse(const std::string& reason) const { m_in.refuse(reason); }

  template <typename T>
  void read_into(std::vector<T>& part) {
    m_in.read(std::as_writable_bytes(std::span(part)));
    m_hash.add(std::as_bytes(std::span(part)));
  }
  template <typename T>
  std::vector<T> read_all(std::uint64_t count) {
    std::vector<T> part = m_in.read_all<T>(count);
    m_hash.add(std::as_bytes(std::span(part)));
    return part;
  }

  /// To be called when all parts are read: refuses trailing bytes and a digest that does not fit.
  void require_intact() {
    m_in.require_end();
    if (as_file_digest(m_hash.hex_digest()) != m_header.content) {
      refuse("is damaged: its checksum does not fit");
    }
  }

 private:
  BinaryReader m_in;
  Header m_header;
  Sha256 m_hash;  ///< of the header with the digest zero, and the parts
};

void write_bytes(std::ostream& out, std::span<const std::byte> bytes);

/// Writes what SealedReader reads, as `write_atomically` does.
template <typename Header>
void write_sealed(const std::filesystem::path& path, Header header, std::span<const std::span<const std::byte>> parts) {
  header.content.fill('\0');
  Sha256 hash;
  hash.add(std::as_bytes(std::span(&header, 1)));
  for (const std::span<const std::byte> part : parts) {
    hash.add(part);
  }
  header.content = as_file_digest(hash.hex_digest());
  write_atomically(path, [&](std::ostream& out) {
    write_bytes(out, std::as_bytes(std::span(&header, 1)));
    for (const std::span<const std::byte> part : parts) {
      write_bytes(out, part);
    }
  });
}

}  // namespace musclebench

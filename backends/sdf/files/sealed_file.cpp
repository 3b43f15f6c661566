#include "backends/sdf/files/sealed_file.hpp"

#include <algorithm>
#include <fstream>
#include <utility>

#include <fmt/format.h>

#include "core/base/input_error.hpp"

namespace musclebench {

FileDigest as_file_digest(const std::string& text) {
  FileDigest digest{};
  std::copy_n(text.begin(), std::min(text.size(), digest.size()), digest.begin());
  return digest;
}

std::string first_difference(const FileMark& found, const FileMark& wanted, const std::string& kind) {
  if (found.name != wanted.name) {
    return "is not " + kind;
  }
  if (found.byte_order != wanted.byte_order) {
    return "was written on a machine of another byte order";
  }
  if (found.version != wanted.version) {
    return fmt::format("has format version {}, this program reads {}", found.version, wanted.version);
  }
  return "";
}

BinaryReader::BinaryReader(const std::filesystem::path& path, Words words) : m_path(path), m_words(std::move(words)) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    refuse(std::filesystem::exists(path, error) ? "is no regular file" : "cannot be read");
  }
  m_left = std::filesystem::file_size(path, error);
  m_in.open(path, std::ios::binary);
  if (error || !m_in.is_open()) {
    refuse("cannot be read");
  }
}

void BinaryReader::refuse(const std::string& reason) const {
  throw InputError(m_path.string(), reason + "; " + m_words.cure);
}

void BinaryReader::require(bool is_there) const {
  if (!is_there) {
    refuse(m_words.truncated);
  }
}

void BinaryReader::read(std::span<std::byte> bytes) {
  require(bytes.size() <= m_left);
  if (!bytes.empty() && !m_in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()))) {
    refuse("cannot be read");
  }
  m_left -= bytes.size();
}

void BinaryReader::require_end() const {
  if (m_left > 0) {
    refuse("goes on after its end");
  }
}

BinaryReader::Words sealed_file_words() {
  return {"is truncated", "remove the file or name another folder in `structures`"};
}

void write_bytes(std::ostream& out, std::span<const std::byte> bytes) {
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace musclebench

#include "core/base/input_file.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/base/system_memory.hpp"

namespace musclebench {

InputFile::InputFile(const std::filesystem::path& path) : m_location(path.string()) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    throw InputError(m_location, "cannot be read: there is no such file; check the path");
  }
  // Asked first: opening a pipe would wait for its writer.
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw InputError(m_location, "cannot be read: it is no regular file but a folder, pipe or device; name a file");
  }
  m_stream.open(path, std::ios::binary);
  if (!m_stream.is_open()) {
    throw InputError(m_location, "cannot be read; check its permissions");
  }
  m_bytes = std::filesystem::file_size(path, ignored);
}

std::string InputFile::head(std::size_t most) {
  std::string bytes(static_cast<std::size_t>(std::min<std::uintmax_t>(m_bytes, most)), '\0');
  m_stream.clear();
  m_stream.seekg(0);
  m_stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (m_stream.bad()) {
    throw InputError(m_location, "cannot be read to its end; copy it again");
  }
  bytes.resize(static_cast<std::size_t>(m_stream.gcount()));
  return bytes;
}

std::string InputFile::text(std::uintmax_t most) {
  if (m_bytes > most) {
    throw InputError(m_location,
                     fmt::format("has {} bytes, where at most {} make sense; is it the right file?", m_bytes, most));
  }
  require_memory(static_cast<std::size_t>(m_bytes), m_location, "name a smaller file");
  return head(static_cast<std::size_t>(m_bytes));
}

}  // namespace musclebench

#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace musclebench {

/// A file that the user names, read on demand. Throws InputError (location: the path) for a file that is missing, may
/// not be read, or is not regular: a pipe or a device may never end.
class InputFile {
 public:
  explicit InputFile(const std::filesystem::path& path);

  [[nodiscard]] std::uintmax_t bytes() const { return m_bytes; }
  /// The first bytes, at most `most`.
  [[nodiscard]] std::string head(std::size_t most);
  /// All bytes. Throws InputError where there are more than `most`, or more than the memory holds.
  [[nodiscard]] std::string text(std::uintmax_t most = UINTMAX_MAX);

 private:
  std::string m_location;
  std::ifstream m_stream;
  std::uintmax_t m_bytes = 0;
};

}  // namespace musclebench

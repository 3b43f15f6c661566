#pragma once

#include <filesystem>
#include <fstream>
#include <ostream>

namespace musclebench {

/// A file whose every failure, up to closing, is an InputError.
class OutputFile {
 public:
  explicit OutputFile(const std::filesystem::path& path);
  std::ostream& stream() { return m_stream; }
  /// Throws when what was written so far did not reach the file.
  void check() const;
  void close();

 private:
  std::filesystem::path m_path;
  std::ofstream m_stream;
};

}  // namespace musclebench

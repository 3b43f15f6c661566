#include "core/base/output_file.hpp"

#include "core/base/input_error.hpp"

namespace musclebench {

OutputFile::OutputFile(const std::filesystem::path& path) : m_path(path), m_stream(path, std::ios::binary) { check(); }

void OutputFile::check() const {
  if (!m_stream) {
    throw InputError(m_path.string(), "cannot be written; is the disk full or the folder write-protected?");
  }
}

void OutputFile::close() {
  m_stream.close();
  check();
}

}  // namespace musclebench

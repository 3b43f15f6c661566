#include "core/fuzz/fuzzed_reader.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <unistd.h>

#include <fmt/format.h>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

bool is_one_line(std::string_view text) {
  constexpr std::size_t longest = 8000;  // with the paths of two files
  return !text.empty() && text.size() < longest &&
         std::ranges::none_of(text, [](unsigned char c) { return c < ' ' || c == 127; });
}

}  // namespace

bool reads(const FuzzedReader& reader, std::string_view bytes) {
  try {
    reader.read(bytes);
    return true;
  } catch (const InputError& error) {
    if (!is_one_line(error.what())) {
      throw std::logic_error(fmt::format("a complaint that is not one line that can be read: {}", error.what()));
    }
    return false;
  }
}

TemporaryFile::TemporaryFile(std::string_view bytes, std::string_view ending)
    : m_path(std::filesystem::temp_directory_path() / fmt::format("musclebench-fuzz-{}{}", getpid(), ending)) {
  std::ofstream file(m_path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  // A reader that is fed with less than what it should be would look sound.
  if (!file.flush()) throw std::runtime_error(fmt::format("{}: cannot be written", m_path.string()));
}

TemporaryFile::~TemporaryFile() {
  std::error_code ignored;
  std::filesystem::remove(m_path, ignored);
}

std::string TemporaryFile::bytes() const {
  std::ifstream file(m_path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace musclebench

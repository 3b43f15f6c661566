#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace musclebench {

/// A reader of files, fed with any bytes by libFuzzer (tools/fuzz) and with its corpus by a test. It reads them, or
/// refuses them with an InputError of one line; anything else that it throws is a defect, as is a sanitizer's report.
struct FuzzedReader {
  std::string_view name;  ///< of its folder in `corpus`
  void (*read)(std::string_view bytes);
  /// Files to start from that only the program can write; none where all stand in `corpus`.
  std::vector<std::string> (*make_seeds)() = nullptr;
};

/// Defined once in each program, beside its readers.
std::span<const FuzzedReader> fuzzed_readers();

/// Whether `reader` read the bytes; false: it refused them. Throws what the reader throws beside InputError.
bool reads(const FuzzedReader& reader, std::string_view bytes);

/// Bytes as a file of this process, which is gone with this.
class TemporaryFile {
 public:
  TemporaryFile(std::string_view bytes, std::string_view ending);
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile();

  [[nodiscard]] const std::filesystem::path& path() const { return m_path; }
  /// What stands in the file now.
  [[nodiscard]] std::string bytes() const;

 private:
  std::filesystem::path m_path;
};

}  // namespace musclebench

#include "core/base/atomic_file.hpp"

#include <fstream>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

/// Gone at the end, whatever happens, unless it was renamed.
struct TemporaryFile {
  explicit TemporaryFile(std::filesystem::path where) : path(std::move(where)) {}
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
  std::filesystem::path path;
};

}  // namespace

void write_atomically(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write) {
  std::error_code error;
  if (path.has_parent_path()) {
    std::filesystem::create_directories(path.parent_path(), error);
  }
  const TemporaryFile temporary(path.string() + fmt::format(".{}.part", getpid()));
  bool written = false;
  {
    std::ofstream out(temporary.path, std::ios::binary | std::ios::trunc);
    write(out);
    out.close();
    written = out.good();
  }
  if (written) {
    std::filesystem::rename(temporary.path, path, error);
  }
  if (!written || error) {
    throw InputError(path.string(), "cannot be written; is the folder writable and is there room on the disk?");
  }
}

}  // namespace musclebench

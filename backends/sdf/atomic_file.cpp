#include "backends/sdf/atomic_file.hpp"

#include <fstream>
#include <unistd.h>

#include <fmt/format.h>

#include "core/base/input_error.hpp"

namespace musclebench {

void write_atomically(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write) {
  std::error_code error;
  if (path.has_parent_path()) {
    std::filesystem::create_directories(path.parent_path(), error);
  }
  const std::filesystem::path temporary = path.string() + fmt::format(".{}.part", getpid());
  bool written = false;
  {
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    write(out);
    out.close();
    written = out.good();
  }
  if (written) {
    std::filesystem::rename(temporary, path, error);
  }
  if (!written || error) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    throw InputError(path.string(), "cannot be written; is the folder writable and is there room on the disk?");
  }
}

}  // namespace musclebench

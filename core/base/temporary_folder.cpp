#include "core/base/temporary_folder.hpp"

#include <cstdlib>
#include <system_error>

#include "core/base/input_error.hpp"

namespace musclebench {

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "musclebench_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr)
    throw InputError(name, "no such folder can be made; set TMPDIR to one with room");
  m_path = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(m_path, ignored);
}

}  // namespace musclebench

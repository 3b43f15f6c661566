#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>

namespace musclebench {

/// The folder of the LHDL hip (with lhdl.json and meshes/): $MUSCLEBENCH_DATA where set, else ../shared/data/lhdl
/// beside the project. Nothing where neither is there; the tests that need it then skip. The data may not be shipped
/// with the project.
inline std::optional<std::filesystem::path> lhdl_folder() {
  std::filesystem::path folder = std::filesystem::path(MUSCLEBENCH_SOURCE_DIR) / ".." / "shared" / "data" / "lhdl";
  if (const char* given = std::getenv("MUSCLEBENCH_DATA"); given != nullptr && *given != '\0') {
    folder = given;
  }
  std::error_code ignored;
  if (std::filesystem::is_regular_file(folder / "lhdl.json", ignored)) {
    return folder;
  }
  return std::nullopt;
}

}  // namespace musclebench

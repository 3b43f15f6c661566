#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// A backend's folder, as CMake found it.
struct BackendSource {
  std::string_view name;    ///< name of the folder
  BackendEntry (*entry)();  ///< makes the row
  std::string_view study;   ///< the text of its study.toml; empty: none
};

/// The folders of all backends in this build. CMake writes this function (cmake/MusclebenchBackends.cmake).
std::span<const BackendSource> backend_table();

/// The table of all backends in this build. Safe from several threads, as are the functions below.
const std::vector<BackendEntry>& backend_registry();

/// The row of the backend `name`. If the name is unknown, throws InputError that names `location` and all known names.
const BackendEntry& find_backend(std::string_view name, const std::string& location = "--backend");

/// The first exact backend of the table. It drives recordings and is the reference of `advise`. Throws InputError if
/// this build has none.
const BackendEntry& exact_backend();

}  // namespace musclebench

#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// One folder of a backend, as CMake found it.
struct BackendSource {
  std::string_view name;  ///< of the folder
  BackendEntry (*entry)();
  std::string_view study;  ///< the text of its study.toml; empty: none
};

/// The folders that a program is built with (cmake/MusclebenchBackends.cmake writes it).
std::span<const BackendSource> backend_table();

/// All backends of this build.
const std::vector<BackendEntry>& backend_registry();

/// The row of `name`. Throws InputError that names `location` and prints the list for an unknown name.
const BackendEntry& find_backend(std::string_view name, const std::string& location = "--backend");

/// The first exact row: it drives recordings and is the reference of advice. Throws InputError where there is none.
const BackendEntry& exact_backend();

}  // namespace musclebench

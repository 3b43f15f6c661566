#include "backends/registry.hpp"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/input_error.hpp"

namespace musclebench {

const std::vector<BackendEntry>& backend_registry() {
  static const std::vector<BackendEntry> entries = [] {
    std::vector<BackendEntry> made;
    for (const BackendSource& source : backend_table()) {
      made.push_back(source.entry());
      if (made.back().name != source.name) {
        throw std::logic_error(
            fmt::format("the folder of backend '{}' has an entry with the name '{}'; give both one name", source.name,
                        made.back().name));
      }
      made.back().study = source.study;
    }
    return made;
  }();
  return entries;
}

const BackendEntry& find_backend(std::string_view name, const std::string& location) {
  std::vector<std::string> known;
  for (const BackendEntry& entry : backend_registry()) {
    if (entry.name == name) {
      return entry;
    }
    known.push_back(entry.name);
  }
  throw InputError(location, fmt::format("'{}' is not a backend of this build; did you mean '{}'? There are: {}", name,
                                         nearest_word(std::string(name), known), fmt::join(known, ", ")));
}

const BackendEntry& exact_backend() {
  const auto& entries = backend_registry();
  const auto found = std::find_if(entries.begin(), entries.end(), [](const BackendEntry& e) { return e.exact; });
  if (found == entries.end()) {
    throw InputError("--backend", "this build has no exact backend; name the one that drives the run");
  }
  return *found;
}

}  // namespace musclebench

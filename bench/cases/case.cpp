#include "bench/cases/case.hpp"

#include <fmt/format.h>

#include "core/base/input_error.hpp"

namespace musclebench {

ResponseKind choose_response(const std::string& option, const Scene& scene, const BackendEntry& backend,
                             const Parameters& parameters) {
  const bool by_option = !option.empty();
  if (!by_option && !scene.response) {
    return backend.default_response;
  }
  const ResponseKind chosen = by_option ? find_response(option, "--response") : *scene.response;
  const std::string_view lacking = lacks_for(chosen, backend.make(parameters)->capabilities());
  if (!lacking.empty()) {
    throw InputError(by_option ? "--response " + option : fmt::format("{}: contact.response", scene.name),
                     fmt::format("'{}' has no {}; take '{}', or another backend", backend.name, lacking,
                                 name_of(backend.default_response)));
  }
  return chosen;
}

}  // namespace musclebench

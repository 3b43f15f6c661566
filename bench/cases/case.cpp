#include "bench/cases/case.hpp"

#include <fmt/format.h>

#include "core/base/input_error.hpp"

namespace musclebench {

ResponseKind choose_response(const std::string& option, const Scene& scene, const BackendEntry& backend,
                             const Parameters& parameters, const ColliderBackends& colliders) {
  const bool by_option = !option.empty();
  if (!by_option && !scene.response && colliders.of_bones.empty()) {
    return backend.default_response;
  }
  const ResponseKind chosen = by_option        ? find_response(option, "--response")
                              : scene.response ? *scene.response
                                               : backend.default_response;
  if (!colliders.of_bones.empty()) {
    const std::string_view lacking = lacks_for(chosen, make_backend(backend, parameters, colliders)->capabilities());
    if (lacking.empty()) return chosen;
    throw InputError(by_option ? "--response " + option : fmt::format("{}: response", scene.name),
                     fmt::format("the backends of the bones together have no {}; take another response, or backends "
                                 "that can do '{}'",
                                 lacking, name_of(chosen)));
  }
  const std::string_view lacking = lacks_for(chosen, backend.make(parameters)->capabilities());
  if (!lacking.empty()) {
    throw InputError(by_option ? "--response " + option : fmt::format("{}: contact.response", scene.name),
                     fmt::format("'{}' has no {}; take '{}', or another backend", backend.name, lacking,
                                 name_of(backend.default_response)));
  }
  return chosen;
}

}  // namespace musclebench

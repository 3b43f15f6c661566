#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"
#include "core/contact/response.hpp"

namespace musclebench {

/// One row of the table of backends. A backend has one name everywhere: folder, target, `--backend`, CSV, legend.
struct BackendEntry {
  std::string name;
  std::string help;
  ResponseKind response;
  std::vector<ParameterSpec> parameters;
  std::function<std::unique_ptr<CollisionBackend>(const Parameters&)> make;
};

/// All backends of this build.
const std::vector<BackendEntry>& backend_registry();

/// The row of `name`. Throws InputError that prints the list for an unknown name.
const BackendEntry& find_backend(std::string_view name);

}  // namespace musclebench

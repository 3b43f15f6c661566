#pragma once

#include <functional>
#include <memory>

#include "bench/cases/case.hpp"
#include "core/base/scoped_timer.hpp"

namespace musclebench {

/// The backend of a case, built over the scene's bones.
struct BuiltBackend {
  std::unique_ptr<CollisionBackend> backend;
  Nanoseconds build_ns = 0;  ///< with the build time of structures that the backend shares with the scene
};

/// `report` is called now and then with the share that is done. Throws InputError when the backend's parameters do not
/// fit the scene.
BuiltBackend build_backend(const Case& resolved, const std::function<void(double share)>& report = {});

}  // namespace musclebench

#include "bench/cases/build_backend.hpp"

namespace musclebench {

BuiltBackend build_backend(const Case& resolved, const std::function<void(double share)>& report) {
  BuiltBackend built;
  built.backend = resolved.backend.make(resolved.parameters);
  built.backend->report_build_to(report);
  {
    const ScopedTimer timer(built.build_ns);
    built.backend->build(resolved.scene.bones, resolved.scene.muscle.mesh, resolved.threads);
  }
  return built;
}

}  // namespace musclebench

#include "backends/fcl/fcl_backend.hpp"

#include <fcl/config.h>
#include <fmt/format.h>

#include "backends/fcl/nodes/node_backend.hpp"
#include "backends/fcl/surfaces/muscle_detector.hpp"
#include "backends/fcl/surfaces/surface_backend.hpp"

namespace musclebench {

std::unique_ptr<CollisionBackend> make_fcl_backend(const Parameters& parameters) {
  const FclOptions options = fcl_options(parameters);
  return options.query == Query::surfaces ? make_surface_backend(options) : make_node_backend(options);
}

BackendEntry fcl_entry() {
  return {.name = "fcl",
          .help = "FCL library: muscle and bones as BVH models in dynamic AABB trees (the paper's method)",
          .implementation = fmt::format("FCL {}, BSD-3-Clause", FCL_VERSION),
          .default_response = ResponseKind::project,
          .parameters = fcl_parameters(),
          .for_points = {{"query", std::string("node_distance")}},
          .make = make_fcl_backend,
          .make_muscle_detector = make_fcl_muscle_detector};
}

}  // namespace musclebench

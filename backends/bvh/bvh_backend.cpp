#include "backends/bvh/bvh_backend.hpp"

#include "backends/bvh/exact_surface.hpp"
#include "backends/bvh/muscle_detector.hpp"
#include "core/clearance/cached_point_query.hpp"
#include "core/clearance/point_backend.hpp"

namespace musclebench {

std::unique_ptr<CollisionBackend> make_bvh_backend(const Parameters& parameters) {
  return make_point_backend({.capabilities = {.has_cache = uses_clearance_cache(parameters), .steady_memory = true},
                             .nodes_a_batch = 64,
                             .contact_reach_m = [](const Bone& /*bone*/) { return 0.0; },
                             .build =
                                 [](const Bone& bone, int threads, const ShareReport& /*report*/) {
                                   return std::make_unique<CachedPointQuery<ExactSurface>>(ExactSurface(bone, threads));
                                 }});
}

BackendEntry bvh_entry() {
  return {.name = "bvh",
          .help = "exact: closest point by a tree of boxes over each bone, signed robustly",
          .implementation = "this project",
          .default_response = ResponseKind::project,
          .exact = true,
          .parameters = {clearance_cache_parameter()},
          .make = make_bvh_backend,
          .signed_distance = [](const Bone& bone, int threads) -> SignedDistance {
            const auto surface = std::make_shared<const ExactSurface>(bone, threads);
            return [surface](const Vec3& point) { return surface->signed_distance_m(point); };
          },
          .make_muscle_detector = make_bvh_muscle_detector,
          .make_surface_queries = [](const Parameters& /*parameters*/,
                                     std::span<const Bone> /*bones*/) -> MakeSurfaceQueries {
            return [](const Bone& bone, int /*threads*/) { return exact_surface_queries(bone); };
          }};
}

}  // namespace musclebench

#include "backends/sdf/sdf_backend.hpp"

#include <memory>

#include "backends/sdf/grid_field_source.hpp"
#include "backends/sdf/octree_field_source.hpp"
#include "backends/sdf/sdf_settings.hpp"
#include "core/clearance/point_backend.hpp"

namespace musclebench {

namespace {

std::unique_ptr<FieldSource> make_field_source(const Parameters& parameters) {
  if (wants_octree(parameters)) {
    return make_octree_field_source(parameters);
  }
  return parameters.word("discregrid").empty() ? make_grid_field_source(parameters)
                                               : make_discregrid_field_source(parameters);
}

}  // namespace

std::unique_ptr<CollisionBackend> make_sdf_backend(const Parameters& parameters) {
  const std::shared_ptr<const FieldSource> source = make_field_source(parameters);
  return make_point_backend(
      {.capabilities = {.has_cache = uses_clearance_cache(parameters), .has_step = true, .steady_memory = true},
       .cache_needs_closed_bones = source->needs_closed_surfaces(),
       .require_fit = [source](std::span<const Bone> bones) { source->require_fit(bones); },
       .contact_reach_m = [source](const Bone& bone) { return source->contact_reach_m(bone); },
       .build_part =
           [source](const Bone& bone, int threads, const ShareReport& report, const Eigen::AlignedBox3d& expected) {
             return source->make(bone, threads, report, expected);
           }});
}

}  // namespace musclebench

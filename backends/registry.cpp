#include "backends/registry.hpp"

#include <fmt/format.h>

#include "backends/brute_force/brute_force_backend.hpp"
#include "backends/bvh/bvh_backend.hpp"
#include "backends/null/null_backend.hpp"
#include "backends/sdf/sdf_backend.hpp"
#include "backends/voxel/voxel_backend.hpp"
#include "core/base/input_error.hpp"
#ifdef MUSCLEBENCH_WITH_FCL
#include "backends/fcl/fcl_backend.hpp"
#endif

namespace musclebench {

const std::vector<BackendEntry>& backend_registry() {
  static const std::vector<BackendEntry> entries = {
      {"null", "no collision: the cost of the loop alone", ResponseKind::project, null_parameters(), make_null_backend},
      {"brute_force", "every node against every triangle: the truth of contacts", ResponseKind::project,
       brute_force_parameters(), make_brute_force_backend},
      {"voxel", "uniform bit grid over each bone (the paper's voxelisation)", ResponseKind::backtrack,
       voxel_parameters(), make_voxel_backend},
      {"sdf", "cubic signed distance field over each bone (the Discregrid method)", ResponseKind::project,
       sdf_parameters(), make_sdf_backend},
      {"bvh", "exact: closest point by a tree of boxes over each bone, signed robustly", ResponseKind::project,
       bvh_parameters(), make_bvh_backend},
#ifdef MUSCLEBENCH_WITH_FCL
      {"fcl", "FCL: muscle and bones as BVH models in dynamic AABB trees (the paper's way)", ResponseKind::project,
       fcl_parameters(), make_fcl_backend},
#endif
  };
  return entries;
}

const BackendEntry& find_backend(std::string_view name) {
  std::string known;
  for (const BackendEntry& entry : backend_registry()) {
    if (entry.name == name) {
      return entry;
    }
    known += (known.empty() ? "" : ", ") + entry.name;
  }
  throw InputError("--backend", fmt::format("'{}' is not a backend of this build; there are: {}", name, known));
}

}  // namespace musclebench

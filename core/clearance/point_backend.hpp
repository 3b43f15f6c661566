#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>

#include "core/clearance/bone_structure.hpp"
#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// Describes a backend that answers each node alone. Give `build` or `build_part`; all else is optional.
struct PointMethod {
  /// If `has_cache` is set, the backend gets a clearance cache. Only nodes without a valid safe sphere are then
  /// queried.
  Capabilities capabilities = {.steady_memory = true};
  /// Whether a distance proves a node free for closed bones only. Across a hole the side changes without a surface. The
  /// cache is then switched off if any bone is open.
  bool cache_needs_closed_bones = false;
  /// Whether a query is cheaper than testing one safe sphere. A few nodes are then queried without the cache. Only a
  /// sweep over many nodes uses it.
  bool asks_few_without_cache = false;
  /// The smallest batch for which starting a thread pays off: some microseconds of work.
  std::size_t nodes_a_batch = 512;
  /// Optional. Called before anything is built. Throws InputError if the parameters do not fit the bones.
  std::function<void(std::span<const Bone>)> require_fit = nullptr;
  /// Optional. How far outside the box of a closed bone a contact can be (CollisionBackend::contact_reach_m), in
  /// metres. Without it no bone is pruned.
  std::function<double(const Bone&)> contact_reach_m = nullptr;
  /// Builds the structure over a bone, which outlives the structure. It may use `threads` threads. If `report` is not
  /// empty, call it with the share done.
  std::function<std::unique_ptr<BoneStructure>(const Bone& bone, int threads, const ShareReport& report)> build =
      nullptr;
  /// Optional. Called instead of `build`. `expected` is the box in the bone's rest frame in which nodes are expected
  /// (CollisionBackend::expect_within). A structure over a part reports queries outside it
  /// (BoneStructure::found_left_out).
  std::function<std::unique_ptr<BoneStructure>(const Bone& bone, int threads, const ShareReport& report,
                                               const Eigen::AlignedBox3d& expected)>
      build_part = nullptr;
};

/// The flag `cull` of backends over other libraries: whether nodes outside the bone's box are told without the library.
ParameterSpec cull_parameter();

/// Makes a complete backend from a PointMethod. It loops over bones and nodes, distributes them to threads, keeps the
/// clearance cache and orders the contacts. The contacts do not depend on the number of threads. A frame allocates no
/// memory.
std::unique_ptr<CollisionBackend> make_point_backend(PointMethod method);

}  // namespace musclebench

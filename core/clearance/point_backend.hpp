#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>

#include "core/clearance/bone_structure.hpp"
#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// Describes a backend that answers node by node, by the structure that it builds over one bone.
struct PointMethod {
  /// With `has_cache` a clearance cache is kept, and only nodes that have left their safe spheres are queried.
  Capabilities capabilities = {.steady_memory = true};
  /// Whether clearances hold for closed bones only: across a hole the side changes where no surface is, so that a
  /// distance alone does not say how far a node is free. With an open bone there is no cache then.
  bool cache_needs_closed_bones = false;
  /// Whether a query costs less than a look at a node's safe sphere: a few nodes are then asked about without the
  /// cache, and only a sweep over all of them gains by it.
  bool asks_few_without_cache = false;
  /// Smallest batch that is worth a thread's start: some microseconds of work.
  std::size_t nodes_a_batch = 512;
  /// Where not empty: throws InputError where the parameters do not fit the bones, before anything is built.
  std::function<void(std::span<const Bone>)> require_fit = nullptr;
  /// How far from the box of a closed bone its contacts may lie (CollisionBackend::contact_reach_m); empty: unknown.
  std::function<double(const Bone&)> contact_reach_m = nullptr;
  /// Builds the structure over a bone, which outlives it; `report`, where not empty, is called with the share done.
  std::function<std::unique_ptr<BoneStructure>(const Bone& bone, int threads, const ShareReport& report)> build =
      nullptr;
  /// Where not empty it is called in place of `build` with the box, in the bone's rest frame, in which nodes are
  /// expected (CollisionBackend::expect_within); a structure over a part notices a point outside of it
  /// (found_left_out).
  std::function<std::unique_ptr<BoneStructure>(const Bone& bone, int threads, const ShareReport& report,
                                               const Eigen::AlignedBox3d& expected)>
      build_part = nullptr;
};

/// Loops over bones and nodes, deals them out to threads, keeps the clearance cache and the order of contacts: the same
/// contacts for any number of threads. Its memory is kept, so that a frame allocates nothing.
std::unique_ptr<CollisionBackend> make_point_backend(PointMethod method);

}  // namespace musclebench

#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "bench/cases/case.hpp"
#include "core/base/scoped_timer.hpp"
#include "core/scene/reach.hpp"

namespace musclebench {

/// The backend of a case, built over the scene's bones.
struct BuiltBackend {
  std::unique_ptr<CollisionBackend> backend;
  Nanoseconds build_ns = 0;      ///< with the build time of structures that the backend shares with the scene
  std::vector<BoneReach> reach;  ///< by bone, by which some were pruned; empty where nothing may be
};

/// A bone over which nothing was built before the first frame, as no muscle was expected to touch it.
struct PrunedResult {
  PrunedBone pruned;
  BoneReach reach;
  std::optional<int> frame_back = {};  ///< in which it was built all the same
};

/// What became of the bones that were pruned by `reach`.
std::vector<PrunedResult> pruned_results(const CollisionBackend& backend, const std::vector<BoneReach>& reach);

/// `report` is called now and then with the share that is done. Throws InputError when the backend's parameters do not
/// fit the scene. What it shared with the scene stays with the bones, for the stages of a simulation to take up.
BuiltBackend build_backend(const Case& resolved, const std::function<void(double share)>& report = {});

/// After the last of those who need what the bones share: gives the memory back, but for what backend and stages keep.
void release_shared(const Scene& scene);

}  // namespace musclebench

#pragma once

#include <vector>

#include "core/scene/scene.hpp"

namespace musclebench {

/// How near the muscles come to a bone in the whole motion, as the attachments and the shape at rest let expect.
struct BoneReach {
  double distance_m = 0;  ///< between their boxes, where they are nearest
  double margin_m = 0;    ///< by which muscles may bulge, fold or swing beyond that
  /// Beyond the margin and closed. A prediction: backends and contact stages watch such a bone and build what they need
  /// when a node comes within reach all the same (CollisionBackend::expect_untouched).
  bool is_untouched = false;
};

/// Of each bone. A muscle is expected in the box around its bound nodes, which move with their bones, grown by as much
/// as it exceeds that box at rest.
std::vector<BoneReach> predict_reach(const Scene& scene);

/// By bone, 0 or 1.
std::vector<char> untouched_bones(const std::vector<BoneReach>& reach);

}  // namespace musclebench

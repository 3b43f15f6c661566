#pragma once

#include <vector>

#include "core/mesh/mesh_size.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// How near the muscles come to a bone in the whole motion, as the attachments and the shape at rest let expect.
struct BoneReach {
  double distance_m = 0;  ///< between their boxes, where they are nearest
  double margin_m = 0;    ///< by which muscles may bulge, fold or swing beyond that
  /// Beyond the margin and closed. A prediction: backends and contact stages watch such a bone and build what they need
  /// when a node comes within reach all the same (CollisionBackend::expect_within).
  bool is_untouched = false;
  /// In the bone's rest frame: where muscles are expected at any time, with the margin; unbounded where nothing is
  /// known.
  Eigen::AlignedBox3d box = unbounded_box();
};

/// Of each bone. A muscle is expected in the box around its bound nodes, which move with their bones, grown by as much
/// as it exceeds that box at rest.
std::vector<BoneReach> predict_reach(const Scene& scene);

/// By bone, for CollisionBackend::expect_within: empty for one that is untouched.
std::vector<Eigen::AlignedBox3d> expected_boxes(const std::vector<BoneReach>& reach);

}  // namespace musclebench

#pragma once

namespace musclebench {

/// A node that is attached to a bone.
struct BoundNode {
  int node = 0;
  int bone = 0;
};

}  // namespace musclebench

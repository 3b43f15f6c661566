#pragma once

namespace musclebench {

/// A muscle node that is attached to a bone and moves with it. Both are indices.
struct BoundNode {
  int node = 0;
  int bone = 0;
};

}  // namespace musclebench

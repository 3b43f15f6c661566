#pragma once

#include <vector>

namespace musclebench {

/// The attached nodes of one muscle, numbered from its first node. `origin` has those on the bones that the muscle
/// comes from, `insertion` all others.
struct EndNodes {
  std::vector<int> origin;
  std::vector<int> insertion;
};

}  // namespace musclebench

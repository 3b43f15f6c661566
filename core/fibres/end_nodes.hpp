#pragma once

#include <vector>

namespace musclebench {

/// The attached nodes of one muscle, numbered from its first node. `origin` has those on the bone of the first
/// attachment, `insertion` all others.
struct EndNodes {
  std::vector<int> origin;
  std::vector<int> insertion;
};

}  // namespace musclebench

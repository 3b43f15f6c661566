#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace musclebench {

/// Disjoint sets of numbers, each told by its smallest.
class JoinedSets {
 public:
  void reset(std::size_t count) {
    m_parents.resize(count);
    std::iota(m_parents.begin(), m_parents.end(), 0);
  }
  int find(int item) {
    while (parent(item) != item) item = parent(item) = parent(parent(item));
    return item;
  }
  void join(int one, int other) {
    one = find(one);
    other = find(other);
    parent(std::max(one, other)) = std::min(one, other);
  }

 private:
  int& parent(int item) { return m_parents[static_cast<std::size_t>(item)]; }

  std::vector<int> m_parents;
};

}  // namespace musclebench

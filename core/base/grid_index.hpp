#pragma once

#include <array>
#include <cstddef>

namespace musclebench {

/// Numbers the items (cells, vertices, blocks) of a regular grid as they lie in memory, x changing fastest.
struct GridIndex {
  using Coordinates = std::array<std::size_t, 3>;

  Coordinates count{};  ///< along each axis

  [[nodiscard]] std::size_t size() const { return count[0] * count[1] * count[2]; }
  [[nodiscard]] std::size_t index(std::size_t i, std::size_t j, std::size_t k) const {
    return (k * count[1] + j) * count[0] + i;
  }
  [[nodiscard]] std::size_t index(const Coordinates& at) const { return index(at[0], at[1], at[2]); }
  [[nodiscard]] Coordinates coordinates(std::size_t index) const {
    return {index % count[0], index / count[0] % count[1], index / (count[0] * count[1])};
  }
};

/// Calls visit(i, j, k) for all items from `from` to before `end`, in the order of their index.
template <typename Visit>
void for_each_in(const GridIndex::Coordinates& from, const GridIndex::Coordinates& end, const Visit& visit) {
  for (std::size_t k = from[2]; k < end[2]; ++k) {
    for (std::size_t j = from[1]; j < end[1]; ++j) {
      for (std::size_t i = from[0]; i < end[0]; ++i) {
        visit(i, j, k);
      }
    }
  }
}

}  // namespace musclebench

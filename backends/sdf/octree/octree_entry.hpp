#pragma once

#include <cstddef>
#include <cstdint>

namespace musclebench::octree_entry {

/// An entry of an octree: its kind in the two upper bits, an offset in the others.
enum class Kind : std::uint32_t {
  split = 0,    ///< the first of its eight children, x changing fastest; they follow each other
  outside = 1,  ///< outside for certain; a coefficient: lower bound of the distance at its centre, in metres
  quadratic = 2,
  cubic = 3  ///< the first coefficient
};

inline constexpr int offset_bits = 30;
inline constexpr std::uint32_t most_offsets = std::uint32_t{1} << offset_bits;
constexpr std::uint32_t entry(Kind kind, std::size_t offset) {
  return static_cast<std::uint32_t>(kind) << offset_bits | static_cast<std::uint32_t>(offset);
}
constexpr Kind kind_of(std::uint32_t entry) { return static_cast<Kind>(entry >> offset_bits); }
constexpr std::size_t offset_of(std::uint32_t entry) { return entry & (most_offsets - 1); }

}  // namespace musclebench::octree_entry

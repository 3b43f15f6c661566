#pragma once

#include <cstddef>
#include <cstdint>

namespace musclebench::octree_entry {

/// An entry of an octree: what it is in the two upper bits, where to go on in the others.
enum class Kind : std::uint32_t {
  split = 0,    ///< the first of its eight children, x changing fastest; they follow each other
  outside = 1,  ///< outside for certain; a coefficient: lower bound of the distance at its centre, in metres
  quadratic = 2,
  cubic = 3  ///< the first coefficient
};

inline constexpr int place_bits = 30;
inline constexpr std::uint32_t most_places = std::uint32_t{1} << place_bits;
constexpr std::uint32_t entry(Kind kind, std::size_t place) {
  return static_cast<std::uint32_t>(kind) << place_bits | static_cast<std::uint32_t>(place);
}
constexpr Kind kind_of(std::uint32_t entry) { return static_cast<Kind>(entry >> place_bits); }
constexpr std::size_t place_of(std::uint32_t entry) { return entry & (most_places - 1); }

}  // namespace musclebench::octree_entry

#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/bvh/triangle_bvh_nodes.hpp"

namespace musclebench {

/// Farther than anything is, m, where there is nothing.
inline constexpr float nowhere_m = 1e6F;

/// More than single precision rounds a distance away, relative.
inline constexpr float lane_rounding = 1e-6F;

/// What is left of a distance after an approach: less than the exact difference, so that errors do not add up.
inline float left_after(float left_m, float approach_m) {
  constexpr float ulp = 0x1p-23F;
  return left_m - (approach_m + ulp * std::abs(left_m));
}

/// Spheres around eight parts of a surface that moves straight, in single precision and larger than they were by more
/// than its rounding.
struct alignas(32) SphereLanes {
  std::array<BvhLanes, 3> from;  ///< centres, m
  std::array<BvhLanes, 3> move;
  BvhLanes radius_m;
  BvhLanes spread_m;  ///< nothing in the sphere moves otherwise than its centre by more
};

/// How far apart the contents of eight spheres are from those of eight others at least, m: a row for each of the first.
/// Aligned as SphereLanes.
using PairDistances = std::array<BvhLanes, bvh_width>;

/// Raises the distances to what the spheres tell of the start, and finds the pairs that may then come closer than
/// `least_m` or are closer than `soon_m`: bit 8 i + j for row i and column j.
std::uint64_t used_up_slots(const SphereLanes& first, const SphereLanes& second, float least_m, float soon_m,
                            PairDistances& left_m);

/// Takes off how far the spheres approach each other, and returns the least that is left.
float take_off_approach(const SphereLanes& first, const SphereLanes& second, PairDistances& left_m);

}  // namespace musclebench

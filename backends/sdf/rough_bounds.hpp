#pragma once

#include <array>
#include <cstddef>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// What is known of cells that follow each other along x, for a few operations each: bounds that are never too tight,
/// from the values as they stand in memory. Most cells of a field are plainly positive or negative, and flat.
struct RoughBounds {
  static constexpr std::size_t capacity = 64;
  static constexpr std::size_t padding = 16;  ///< vectors are written whole
  using Floats = std::array<float, capacity + padding>;

  alignas(64) Floats lowest_corner;  ///< a value at a corner, to the bit
  alignas(64) Floats lowest;         ///< no Bernstein coefficient of the cell is less, nor rounded in double
  alignas(64) Floats steepest;       ///< `CubicCell::steepest` is not more than this times `growth`

  /// What floats round, of the largest value V of the cell. An edge's bubble is 3 a - 1.5 b of differences of values,
  /// or that and -1.5 c: at most 12 V, rounded by 4 u (u = 2^-24). The three axes together by 144 u V, which is less
  /// than half of this.
  static constexpr float rounding = 2e-5F;
  /// Differences of values on an edge are at most 3 times the longest rise E of its polygon of coefficients, and every
  /// rise and bubble is 6 of them at most, rounded by 5 u: 90 u E, and the sums and squares 10 u more.
  static constexpr float growth = 1 + 1e-4F;
};

/// The four rows of values (GridShape) about up to `RoughBounds::capacity` cells, from the first cell's vertices on:
/// those at the lower y and z, at the lower y, at the lower z, and at the upper ones.
using CellRows = std::array<const float*, 4>;

void bound_roughly(const CellRows& rows, std::size_t count, const Vec3& cell_size_m, RoughBounds& bounds);

}  // namespace musclebench

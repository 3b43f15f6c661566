#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A field as its kernels read it. What it points to is the field's.
struct FieldView {
  const float* values;          ///< from those of the first grid vertex on (see GridShape)
  std::array<double, 3> cells;  ///< along each axis
  std::array<double, 3> cells_per_m;
};

/// Query points that are evaluated together, side by side: their positions in a field, and its value and gradient.
struct FieldBlock {
  static constexpr std::size_t capacity = 128;
  static constexpr std::size_t most_lanes = 4;
  /// Vectors are written whole, and aligned.
  template <typename Scalar>
  struct alignas(64) Lanes : std::array<Scalar, capacity + most_lanes> {};

  std::size_t count = 0;
  bool found_left_out = false;  ///< a query in a cell that the grid leaves out (GridShape)
  Lanes<double> x, y, z;        ///< in units of the field's cells
  Lanes<double> value_m;
  Lanes<double> slope_x, slope_y, slope_z;  ///< by metres along the field's axes
  Lanes<std::uint64_t> query;               ///< index of the query; ascending

  [[nodiscard]] Vec3 cells(std::size_t n) const { return {x[n], y[n], z[n]}; }
  [[nodiscard]] Vec3 slope(std::size_t n) const { return {slope_x[n], slope_y[n], slope_z[n]}; }

  /// Whole vectors are computed: the lanes that are left over repeat the last point. Not empty.
  void fill_last_vector() {
    for (std::size_t n = count; n < count + most_lanes; ++n) {
      x[n] = x[count - 1];
      y[n] = y[count - 1];
      z[n] = z[count - 1];
      query[n] = query[count - 1];
    }
  }
};

}  // namespace musclebench

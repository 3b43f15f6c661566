#pragma once

#include "backends/sdf/grid/grid_shape.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// Maps a world position to units of the field's cells, from the lower corner of those that are kept.
struct CellMap {
  Mat3 to_cells;
  Vec3 offset;      ///< to the corner of the domain
  Vec3 first_cell;  ///< taken off at last, which is exact: a point has the same place in its cell whatever is left out

  CellMap(const GridShape& shape, const RigidMotion& pose)
      : to_cells(shape.cell_size_m.cwiseInverse().asDiagonal() * pose.rotation.transpose()),
        offset(-(to_cells * pose.translation_m) - shape.lower_m.cwiseQuotient(shape.cell_size_m)),
        first_cell(shape.first_cell()) {}
  /// For rest-frame positions relative to the domain's lower corner: without rounding of the borders.
  explicit CellMap(const GridShape& shape)
      : to_cells(shape.cell_size_m.cwiseInverse().asDiagonal()), offset(Vec3::Zero()), first_cell(shape.first_cell()) {}

  /// NaN for a NaN position.
  [[nodiscard]] Vec3 apply(const Vec3& position) const { return (to_cells * position + offset) - first_cell; }
};

}  // namespace musclebench

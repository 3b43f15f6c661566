#pragma once

#include "backends/sdf/grid/grid_shape.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// Maps a world position to units of the field's cells, from its lower corner.
struct CellMap {
  Mat3 to_cells;
  Vec3 offset;

  CellMap(const GridShape& shape, const RigidMotion& pose)
      : to_cells(shape.cell_size_m.cwiseInverse().asDiagonal() * pose.rotation.transpose()),
        offset(-(to_cells * pose.translation_m) - shape.lower_m.cwiseQuotient(shape.cell_size_m)) {}
  /// For rest-frame positions relative to the field's lower corner: without rounding of the borders.
  explicit CellMap(const GridShape& shape)
      : to_cells(shape.cell_size_m.cwiseInverse().asDiagonal()), offset(Vec3::Zero()) {}

  /// NaN for a NaN position.
  [[nodiscard]] Vec3 apply(const Vec3& position) const { return to_cells * position + offset; }
};

}  // namespace musclebench

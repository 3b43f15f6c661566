#pragma once

#include "backends/sdf/grid/grid_shape.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// Where a field sits in the world: maps a position to units of the field's cells, from its lower corner.
struct CellMap {
  Mat3 to_cells;
  Vec3 offset;

  CellMap(const GridShape& shape, const RigidMotion& pose)
      : to_cells(shape.cell_size_m.cwiseInverse().asDiagonal() * pose.rotation.transpose()),
        offset(-(to_cells * pose.translation_m) - shape.lower_m.cwiseQuotient(shape.cell_size_m)) {}
  /// Of positions in the rest frame that are given from the field's lower corner: borders stay where they are.
  explicit CellMap(const GridShape& shape)
      : to_cells(shape.cell_size_m.cwiseInverse().asDiagonal()), offset(Vec3::Zero()) {}

  /// Not a number where the position is none.
  [[nodiscard]] Vec3 apply(const Vec3& position) const { return to_cells * position + offset; }
};

}  // namespace musclebench

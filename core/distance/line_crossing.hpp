#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// How a line passes through a triangle: +1 along its normal by the winding, -1 against it, 0 where it misses it. The
/// corners are seen from a point of the line in any frame whose x axis is the line, right-handed.
///
/// Decided edge by edge, in projection along the line: an edge counts where it passes the level of the line (half open,
/// so that a corner counts once) on the right of it, in arithmetic that is the same for both of its triangles. So the
/// test is watertight: the triangles about the line neither overlap nor leave a gap, whatever is rounded.
inline int turns_about_line(const std::array<Vec3, 3>& corners) {
  int turns = 0;  // of the projected triangle about the line: edges on the right of it upwards, less those downwards
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3* low = &corners[i];
    const Vec3* high = &corners[(i + 1) % 3];
    if ((low->z() > 0) == (high->z() > 0)) {
      continue;
    }
    const int up_or_down = low->z() > high->z() ? -1 : 1;
    if (up_or_down < 0) std::swap(low, high);
    if (low->y() * high->z() - high->y() * low->z() > 0) turns += up_or_down;
  }
  return turns;
}

}  // namespace musclebench

#include "backends/sdf/build/field_memory.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "core/base/system_memory.hpp"

namespace musclebench {

void require_room(std::span<const GridShape> shapes, const GridSettings& grid) {
  double bytes = 0;
  for (const GridShape& shape : shapes) bytes += CubicField::bytes_needed(shape);
  // Bytes grow with the third power of the cells along an axis.
  const double share = std::cbrt(static_cast<double>(available_memory_bytes()) / bytes);
  if (grid.cell_size_m > 0) {
    require_memory(static_cast<std::size_t>(bytes), "sdf: cell_size_m",
                   fmt::format("cells of {:.2g} m fit", 1.05 * grid.cell_size_m / share));
  } else {
    require_memory(static_cast<std::size_t>(bytes), "sdf: cells",
                   fmt::format("{:.0f} cells fit", std::max(1.0, std::floor(0.95 * grid.cells * share))));
  }
}

}  // namespace musclebench

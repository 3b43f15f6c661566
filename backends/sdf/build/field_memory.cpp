#include "backends/sdf/build/field_memory.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "core/base/system_memory.hpp"
#include "core/mesh/surface_volume.hpp"

namespace musclebench {

double bytes_to_build(const TriangleMesh& surface, const GridShape& shape, const FieldSettings& settings) {
  const double dense = CubicField::bytes_needed(shape, settings.precision);
  if (!settings.band_m) {
    return dense;
  }
  double area_m2 = 0;
  for (const auto& [a, b, c] : surface.triangles) {
    const Vec3& corner = surface.vertices[static_cast<std::size_t>(a)];
    area_m2 += 0.5 * (surface.vertices[static_cast<std::size_t>(b)] - corner)
                         .cross(surface.vertices[static_cast<std::size_t>(c)] - corner)
                         .norm();
  }
  // A layer about a bone is the thicker the farther out; and cells are kept whole, with all their nodes.
  constexpr double thicker = 1.3;
  constexpr double index_bytes_a_cell = 1.5;
  const double layer_m = *settings.band_m + shape.cell_size_m.norm();
  const double kept_m3 = std::abs(surface_volume_m3(surface.vertices, surface.triangles)) + thicker * area_m2 * layer_m;
  const double cells = static_cast<double>(shape.cells[0]) * shape.cells[1] * shape.cells[2];
  const double share = std::min(1.0, kept_m3 / (shape.upper_m() - shape.lower_m).prod());
  return share * dense + index_bytes_a_cell * cells;
}

void require_room(std::span<const Bone> bones, std::span<const GridShape> shapes, const GridSettings& grid,
                  const FieldSettings& settings) {
  double bytes = 0;
  for (std::size_t b = 0; b < shapes.size(); ++b) {
    bytes += bytes_to_build(bones[b].surface.mesh, shapes[b], settings);
  }
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

#pragma once

#include <functional>
#include <random>
#include <vector>

#include "backends/sdf/grid/cubic_field.hpp"

namespace musclebench {

/// Calls visit(offset, position) for every node of the grid, where offset is that of its stored value.
inline void for_each_node(const GridShape& shape, const std::function<void(std::size_t, const Vec3&)>& visit) {
  // Offsets in a record, and thirds of a cell along x, y, z.
  static constexpr int nodes[7][4] = {{0, 0, 0, 0}, {1, 0, 1, 0}, {2, 0, 2, 0}, {3, 0, 0, 1},
                                      {4, 0, 0, 2}, {5, 1, 0, 0}, {6, 2, 0, 0}};
  for (int k = 0; k <= shape.cells[2]; ++k) {
    for (int j = 0; j <= shape.cells[1]; ++j) {
      for (int i = 0; i <= shape.cells[0]; ++i) {
        for (const auto& [offset, x, y, z] : nodes) {
          if ((x == 0 || i < shape.cells[0]) && (y == 0 || j < shape.cells[1]) && (z == 0 || k < shape.cells[2])) {
            const std::size_t record =
                shape.record(static_cast<std::size_t>(i), static_cast<std::size_t>(j), static_cast<std::size_t>(k));
            visit(record + static_cast<std::size_t>(offset),
                  shape.lower_m + shape.cell_size_m.cwiseProduct(Vec3(i + x / 3.0, j + y / 3.0, k + z / 3.0)));
          }
        }
      }
    }
  }
}

/// A field with the values of `function` at its nodes, and no mask.
inline CubicField interpolate(const GridShape& shape, const std::function<double(const Vec3&)>& function) {
  CubicField field(shape);
  for_each_node(shape, [&](std::size_t offset, const Vec3& position) { field.store(offset, function(position)); });
  return field;
}

/// Random points of the whole domain, the same in every call.
inline std::vector<Vec3> points_over(const GridShape& shape, int count) {
  std::mt19937 generator(13);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Vec3> points;
  for (int n = 0; n < count; ++n) {
    const double x = unit(generator);
    const double y = unit(generator);
    points.push_back(shape.lower_m + Vec3(x, y, unit(generator)).cwiseProduct(shape.upper_m() - shape.lower_m));
  }
  return points;
}

}  // namespace musclebench

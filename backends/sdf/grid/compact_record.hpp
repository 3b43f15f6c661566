#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace musclebench {

/// A grid vertex's seven values (see GridShape) in 16 bytes: its own in single precision, and the differences of its
/// six edge nodes from it in integer steps. A distance is 1-Lipschitz, so that 16 bits resolve an edge node to 1/98,000
/// (first third) or 1/49,000 (second) of the edge: some hundredths of a micrometre.
struct CompactRecord {
  float own = 0;
  std::array<std::int16_t, 6> steps{};  ///< nodes along y, z, x, as in a record
};
static_assert(sizeof(CompactRecord) == 16);

/// Metres a step of each edge node of a grid.
using CompactSteps = std::array<float, 6>;

inline CompactSteps compact_steps(double cell_x_m, double cell_y_m, double cell_z_m) {
  // A little more than the distance to the node, for the rounding of both values.
  const auto step = [](double edge_m, int thirds) { return static_cast<float>(edge_m * thirds / 3 * 1.0001 / 32767); };
  return {step(cell_y_m, 1), step(cell_y_m, 2), step(cell_z_m, 1),
          step(cell_z_m, 2), step(cell_x_m, 1), step(cell_x_m, 2)};
}

inline float compact_value(const CompactRecord& record, std::size_t edge_node, const CompactSteps& steps) {
  return record.own + static_cast<float>(record.steps[edge_node]) * steps[edge_node];
}

/// The record's own value has to be there already.
inline void store_compact(CompactRecord& record, std::size_t edge_node, double value, const CompactSteps& steps) {
  const double wanted = (value - static_cast<double>(record.own)) / static_cast<double>(steps[edge_node]);
  record.steps[edge_node] = static_cast<std::int16_t>(std::clamp(std::round(wanted), -32767.0, 32767.0));
}

}  // namespace musclebench

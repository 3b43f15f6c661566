#include "backends/sdf/grid/narrow_band.hpp"

#include <cmath>

namespace musclebench {

NarrowBand::NarrowBand(const GridShape& shape, double width_m) : m_width_m(width_m), m_cells(shape.mask_words()) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    m_blocks.count[axis] = (shape.count(axis) + block_edge - 1) / block_edge;
  }
  m_far_m.resize(m_blocks.size());
}

void NarrowBand::set_far_m(std::size_t i, std::size_t j, std::size_t k, double bound_m) {
  m_far_m[block(i, j, k)] = std::nextafter(static_cast<float>(bound_m), 0.0F);
}

void NarrowBand::index_records(const GridShape& shape) {
  m_vertices.assign((shape.vertex_count() + 63) / 64, 0);
  for_each_in({0, 0, 0}, shape.cell_grid().count, [&](std::size_t i, std::size_t j, std::size_t k) {
    if (!keeps(shape.cell(i, j, k))) {
      return;
    }
    for (const std::size_t corner : {0, 1, 2, 3, 4, 5, 6, 7}) {
      const std::size_t vertex = shape.vertex_index(i + corner % 2, j + corner / 2 % 2, k + corner / 4);
      m_vertices[vertex / 64] |= std::uint64_t{1} << (vertex % 64);
    }
  });
  m_before.clear();
  m_record_count = 0;
  for (const std::uint64_t word : m_vertices) {
    m_before.push_back(static_cast<std::uint32_t>(m_record_count));
    m_record_count += static_cast<std::size_t>(std::popcount(word));
  }
}

}  // namespace musclebench

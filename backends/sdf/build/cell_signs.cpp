#include "backends/sdf/build/cell_signs.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "backends/sdf/build/cell_bounds.hpp"

namespace musclebench {

namespace {

/// Of the cells of one word of the mask.
struct CellSigns {
  std::uint64_t bits = 0;
  double lipschitz_bound = 0;
};

/// Cells whose bounds are computed together.
class CellBatch {
 public:
  /// `lipschitz_bound`: the largest of this thread's cells so far; smaller ones need not be computed exactly.
  CellBatch(const CubicField& field, double& lipschitz_bound, CellSigns& signs)
      : m_field(field), m_lipschitz_bound(lipschitz_bound), m_signs(signs) {}

  void add(std::size_t index) {
    const auto [i, j, k] = m_field.shape().cell_grid().coordinates(index);
    m_index[m_count] = index;
    m_cells[m_count++] = m_field.cell(i, j, k);
    if (m_count == CellBounds::width) {
      find_signs();
    }
  }

  void find_signs() {
    if (m_count == 0) {
      return;
    }
    CellBounds bounds;
    const Vec3& size_m = m_field.shape().cell_size_m;
    bound_cells({m_cells.data(), m_count}, size_m, bounds);
    for (std::size_t n = 0; n < m_count; ++n) {
      const CubicCell& cell = m_cells[n];
      if (bounds.lipschitz_bound[n] * (1 + 1e-12) > m_lipschitz_bound) {
        m_lipschitz_bound = std::max(m_lipschitz_bound, CubicCell::lipschitz_bound(cell.bernstein(), size_m));
      }
      // The bound is computed in floating point; this covers its rounding and that of the evaluation.
      if (bounds.lowest[n] < 1e-12 * std::max(bounds.highest[n], -bounds.lowest[n])) {
        m_signs.bits |= std::uint64_t{1} << (m_index[n] % 64);
      }
    }
    m_signs.lipschitz_bound = m_lipschitz_bound;
    m_count = 0;
  }

 private:
  const CubicField& m_field;
  double& m_lipschitz_bound;
  CellSigns& m_signs;
  std::size_t m_count = 0;
  std::array<std::size_t, CellBounds::width> m_index{};
  std::array<CubicCell, CellBounds::width> m_cells;
};

}  // namespace

void find_cell_signs(CubicField& field, [[maybe_unused]] int threads) {
  // Covers the rounding of the coefficients, and of values kept in single precision.
  constexpr double slack = 1 + 1e-5;
  const GridShape& shape = field.shape();
  std::vector<CellSigns> signs(shape.mask_words());
  double lipschitz_bound = 0;
#pragma omp parallel for schedule(dynamic, 16) num_threads(threads) firstprivate(lipschitz_bound)
  for (std::size_t word = 0; word < signs.size(); ++word) {
    CellBatch batch(field, lipschitz_bound, signs[word]);
    const std::size_t end = std::min(64 * (word + 1), shape.cell_count());
    for (std::size_t index = 64 * word; index < end; ++index) {
      batch.add(index);
    }
    batch.find_signs();
  }
  FieldFacts& facts = field.facts();
  facts.lipschitz_bound = 0;
  for (std::size_t word = 0; word < signs.size(); ++word) {
    field.mask()[word] = signs[word].bits;
    facts.lipschitz_bound = std::max(facts.lipschitz_bound, slack * signs[word].lipschitz_bound);
  }
}

}  // namespace musclebench

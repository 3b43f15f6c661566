#include "backends/sdf/build/cell_signs.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "backends/sdf/build/cell_bounds.hpp"

namespace musclebench {

namespace {

/// A face of a cell on the border of the domain.
struct BorderFace {
  std::size_t axis;
  int side;
  std::array<std::size_t, 3> cell;
};

std::vector<BorderFace> border_faces(const CubicField& field) {
  const GridShape& shape = field.shape();
  std::vector<BorderFace> faces;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t p = (axis + 1) % 3;
    const std::size_t q = (axis + 2) % 3;
    for (const int side : {0, 1}) {
      if ((side == 0 ? shape.cells_before : shape.cells_after)[axis] > 0) continue;
      for (std::size_t a = 0; a < shape.count(p); ++a) {
        for (std::size_t b = 0; b < shape.count(q); ++b) {
          std::array<std::size_t, 3> cell{};
          cell[axis] = side == 0 ? 0 : shape.count(axis) - 1;
          cell[p] = a;
          cell[q] = b;
          if (field.has_coefficients(shape.cell(cell[0], cell[1], cell[2]))) {
            faces.push_back({axis, side, cell});
          }
        }
      }
    }
  }
  return faces;
}

/// Positive by a bound that falls by no edge that is made linear.
bool is_clear(const CubicField& field, const BorderFace& face) {
  const CubicCell cell = field.cell(face.cell[0], face.cell[1], face.cell[2]);
  return cell.rough_lower_bound_on_face(face.axis, face.side) > 1e-9 * field.shape().cell_size_m.norm();
}

void straighten_edge(CubicField& field, std::array<std::size_t, 3> vertex, std::size_t axis) {
  const std::size_t start = field.record(vertex[0], vertex[1], vertex[2]).value();
  const double low = field.stored(start);
  ++vertex[axis];
  const double high = field.stored(field.record(vertex[0], vertex[1], vertex[2]).value());
  field.store(start + GridShape::edge_offset[axis], low + (high - low) / 3);
  field.store(start + GridShape::edge_offset[axis] + 1, low + (high - low) * 2 / 3);
}

void straighten_face(CubicField& field, const BorderFace& face) {
  for (const std::size_t turn : {1, 2}) {
    const std::size_t along = (face.axis + turn) % 3;
    const std::size_t across = (face.axis + 3 - turn) % 3;
    for (const std::size_t far : {0, 1}) {
      std::array<std::size_t, 3> vertex = face.cell;
      vertex[face.axis] += static_cast<std::size_t>(face.side);
      vertex[across] += far;
      straighten_edge(field, vertex, along);
    }
  }
}

}  // namespace

bool has_clear_rim(const CubicField& field) {
  const GridShape& shape = field.shape();
  if (!shape.is_part()) return true;
  const std::vector<BorderFace> faces = border_faces(field);
  return std::ranges::all_of(faces, [&](const BorderFace& face) {
    bool in_rim = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      in_rim |= shape.cells_before[axis] > 0 && face.cell[axis] == 0;
      in_rim |= shape.cells_after[axis] > 0 && face.cell[axis] + 1 == shape.count(axis);
    }
    return !in_rim || is_clear(field, face);
  });
}

void keep_border_positive(CubicField& field) {
  // A face whose edges were made linear shares them with its neighbours, so the faces are checked until nothing
  // changes. Each is made linear at most once.
  std::vector<BorderFace> curved = border_faces(field);
  for (std::size_t before = curved.size() + 1; before != curved.size();) {
    before = curved.size();
    std::erase_if(curved, [&](const BorderFace& face) {
      const bool crosses =
          !is_clear(field, face) &&
          field.cell(face.cell[0], face.cell[1], face.cell[2]).lower_bound_on_face(face.axis, face.side) <= 0;
      if (crosses) {
        straighten_face(field, face);
      }
      return crosses;
    });
  }
}

namespace {

/// Of the cells of one word of the mask.
struct CellSigns {
  std::uint64_t bits = 0;
  double lipschitz_bound = 0;
  double sign_error_distance_m = 0;
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
        // No point of the cell is farther from a vertex than the cell's diagonal.
        const double nearest_m = std::max(0.0, std::min(cell.axis[0].low.minCoeff(), cell.axis[0].high.minCoeff()));
        m_signs.sign_error_distance_m = std::max(m_signs.sign_error_distance_m, nearest_m + size_m.norm());
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
      if (field.has_coefficients(index)) {
        batch.add(index);
      }
    }
    batch.find_signs();
  }
  FieldFacts& facts = field.facts();
  facts.lipschitz_bound = 0;
  facts.sign_error_distance_m = 0;
  for (std::size_t word = 0; word < signs.size(); ++word) {
    field.mask()[word] = signs[word].bits;
    facts.lipschitz_bound = std::max(facts.lipschitz_bound, slack * signs[word].lipschitz_bound);
    facts.sign_error_distance_m = std::max(facts.sign_error_distance_m, slack * signs[word].sign_error_distance_m);
  }
}

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "backends/sdf/compact_record.hpp"
#include "backends/sdf/cubic_cell.hpp"
#include "backends/sdf/cubic_kernel.hpp"
#include "backends/sdf/field_facts.hpp"
#include "backends/sdf/grid_shape.hpp"
#include "backends/sdf/narrow_band.hpp"

namespace musclebench {

struct FieldSample {
  double value_m = 0;
  Vec3 gradient = Vec3::Zero();  ///< of the polynomial: about, but not exactly, of unit length
};

/// A cell of a field and a place in it, in [0, 1]^3.
struct CellPlace {
  std::size_t i, j, k;
  Vec3 at;
};

/// A signed distance field over the box of a bone, cubic in each cell and continuous: negative inside, in metres. Made
/// by `build_field`. On the border of its domain it is positive, so that nothing inside the bone is cut off. It knows
/// every cell, or those of a narrow band only. Queries are const and safe from several threads.
class CubicField {
 public:
  CubicField(const GridShape& shape, FieldPrecision precision);
  CubicField(const GridShape& shape, FieldPrecision precision, NarrowBand band);

  [[nodiscard]] const GridShape& shape() const { return m_shape; }
  [[nodiscard]] FieldPrecision precision() const { return m_precision; }
  /// Nothing for a dense field.
  [[nodiscard]] const std::optional<NarrowBand>& band() const { return m_band; }
  [[nodiscard]] const FieldFacts& facts() const { return m_facts; }
  [[nodiscard]] FieldFacts& facts() { return m_facts; }

  /// Bytes that a dense field of this shape holds.
  [[nodiscard]] static double bytes_needed(const GridShape& shape, FieldPrecision precision);
  /// With all that finds a value.
  [[nodiscard]] std::size_t bytes() const;

  /// Nothing outside the domain and in cells that are not known.
  [[nodiscard]] std::optional<double> value(const Vec3& point) const;
  [[nodiscard]] std::optional<FieldSample> sample(const Vec3& point) const;
  /// The same for many points, faster; value and gradient are not numbers where the field knows nothing.
  void sample(std::span<const Vec3> points, std::span<FieldSample> samples) const;

  /// Nothing outside the domain.
  [[nodiscard]] std::optional<CellPlace> place(const Vec3& point) const;
  [[nodiscard]] bool knows(std::size_t cell) const { return !m_band || m_band->keeps(cell); }
  /// Of a cell that is known.
  [[nodiscard]] CellQuery query(const CellPlace& place) const {
    return {runs(place.i, place.j, place.k), {place.at.x(), place.at.y(), place.at.z()}};
  }
  /// Gradients are along the axes of the unit cell.
  void evaluate(std::span<const CellQuery> queries, std::span<CellAnswer> answers) const {
    evaluate_cells(m_precision, m_steps, queries, answers);
  }

  /// Whether the field may be negative somewhere in this cell; where it says no, it is not.
  [[nodiscard]] bool may_be_negative(std::size_t cell) const {
    return ((m_negative[cell / 64] >> (cell % 64)) & 1U) != 0;
  }

  /// Of a cell that is known.
  [[nodiscard]] CubicCell cell(std::size_t i, std::size_t j, std::size_t k) const;

  /// Where the seven values of a grid vertex stand, for `stored` and `store`: at the offsets that GridShape tells. For
  /// a dense field that is GridShape::record; nothing where the band has no record.
  [[nodiscard]] std::optional<std::size_t> record(std::size_t i, std::size_t j, std::size_t k) const;

  /// For those who make, save and compare fields. A compact field wants a vertex's own value before those of its edges.
  [[nodiscard]] double stored(std::size_t place) const;
  void store(std::size_t place, double value);
  [[nodiscard]] std::vector<float>& single_values() { return m_single; }
  [[nodiscard]] std::vector<double>& double_values() { return m_double; }
  [[nodiscard]] std::vector<CompactRecord>& compact_records() { return m_compact; }
  [[nodiscard]] std::vector<std::uint64_t>& mask() { return m_negative; }
  [[nodiscard]] const std::vector<float>& single_values() const { return m_single; }
  [[nodiscard]] const std::vector<double>& double_values() const { return m_double; }
  [[nodiscard]] const std::vector<CompactRecord>& compact_records() const { return m_compact; }
  [[nodiscard]] const std::vector<std::uint64_t>& mask() const { return m_negative; }

 private:
  void allocate(std::size_t values, std::size_t records);
  [[nodiscard]] std::array<const void*, 4> runs(std::size_t i, std::size_t j, std::size_t k) const {
    const std::size_t vertex = m_shape.vertex_index(i, j, k);
    const std::size_t up_y = m_shape.count(0) + 1;
    const std::size_t up_z = up_y * (m_shape.count(1) + 1);
    return {run(vertex, j, k), run(vertex + up_z, j, k + 1), run(vertex + up_y, j + 1, k),
            run(vertex + up_y + up_z, j + 1, k + 1)};
  }
  [[nodiscard]] const void* run(std::size_t vertex, std::size_t j, std::size_t k) const {
    if (m_band) {
      vertex = m_band->record(vertex);
    }
    // The rows of a dense field of plain values lack the two last values.
    const std::size_t missing = m_band ? 0 : 2 * (k * (m_shape.count(1) + 1) + j);
    switch (m_precision) {
      case FieldPrecision::single_precision:
        return m_single.data() + (GridShape::record_size * vertex - missing);
      case FieldPrecision::double_precision:
        return m_double.data() + (GridShape::record_size * vertex - missing);
      default:
        return m_compact.data() + vertex;
    }
  }
  struct CompactPlace {
    std::size_t record, offset;
  };
  [[nodiscard]] CompactPlace compact_place(std::size_t place) const;

  GridShape m_shape;
  FieldPrecision m_precision;
  CompactSteps m_steps;
  Vec3 m_cells_per_m;
  std::optional<NarrowBand> m_band;
  std::vector<float> m_single;
  std::vector<double> m_double;
  std::vector<CompactRecord> m_compact;
  std::vector<std::uint64_t> m_negative;  ///< one bit a cell
  FieldFacts m_facts;
};

}  // namespace musclebench

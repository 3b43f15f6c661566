#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "backends/sdf/grid/cell_map.hpp"
#include "backends/sdf/grid/compact_record.hpp"
#include "backends/sdf/grid/cubic_cell.hpp"
#include "backends/sdf/grid/field_block.hpp"
#include "backends/sdf/grid/field_facts.hpp"
#include "backends/sdf/grid/grid_shape.hpp"
#include "backends/sdf/grid/narrow_band.hpp"

namespace musclebench {

struct FieldSample {
  double value_m = 0;
  Vec3 gradient = Vec3::Zero();  ///< of the polynomial: about, but not exactly, of unit length
};

/// A signed distance field over the box of a bone, cubic in each cell and continuous: negative inside, in metres. Made
/// by `build_field`. The vertices on the border of its domain are outside the bone. It has coefficients in every cell,
/// or in those of a narrow band only. Queries are const and safe from several threads.
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
  /// With the index of a narrow band.
  [[nodiscard]] std::size_t bytes() const;

  /// Nothing outside the domain and in cells without coefficients.
  [[nodiscard]] std::optional<double> value(const Vec3& point) const;
  [[nodiscard]] std::optional<FieldSample> sample(const Vec3& point) const;

  /// Which of many points are evaluated.
  enum class Wanted : std::uint8_t {
    known,         ///< those in cells with coefficients
    may_be_inside  ///< of those the ones that `may_be_negative` does not exclude
  };
  /// Appends to `block` the `wanted` ones of `nodes` (ascending indices into `positions`) from `first` on, mapped by
  /// `map`, and evaluates them when the block is full or all nodes were visited. Returns the index in `nodes`
  /// to go on at. `query` is the index in `nodes`. A position that is not a number is outside.
  std::size_t sample(const CellMap& map, std::span<const Vec3> positions, std::span<const int> nodes, std::size_t first,
                     Wanted wanted, FieldBlock& block) const;

  /// Nothing outside the domain.
  [[nodiscard]] std::optional<CellPosition> locate(const Vec3& point) const;
  [[nodiscard]] bool has_coefficients(std::size_t cell) const { return !m_band || m_band->keeps(cell); }

  /// Whether the field may be negative somewhere in this cell; false proves that it is not.
  [[nodiscard]] bool may_be_negative(std::size_t cell) const {
    return ((m_negative[cell / 64] >> (cell % 64)) & 1U) != 0;
  }

  /// Of a cell with coefficients.
  [[nodiscard]] CubicCell cell(std::size_t i, std::size_t j, std::size_t k) const;

  /// Offset of the seven values of a grid vertex, for `stored` and `store`, laid out as in GridShape. For a dense field
  /// that is GridShape::record; nothing where the band has no record.
  [[nodiscard]] std::optional<std::size_t> record(std::size_t i, std::size_t j, std::size_t k) const;

  /// To build, save and compare fields. In a compact field a vertex's own value has to be stored before those of its
  /// edges.
  [[nodiscard]] double stored(std::size_t offset) const;
  void store(std::size_t offset, double value);
  [[nodiscard]] std::vector<float>& single_values() { return m_single; }
  [[nodiscard]] std::vector<CompactRecord>& compact_records() { return m_compact; }
  [[nodiscard]] std::vector<std::uint64_t>& mask() { return m_negative; }
  [[nodiscard]] const std::vector<float>& single_values() const { return m_single; }
  [[nodiscard]] const std::vector<CompactRecord>& compact_records() const { return m_compact; }
  [[nodiscard]] const std::vector<std::uint64_t>& mask() const { return m_negative; }

 private:
  void allocate(std::size_t values, std::size_t records);
  [[nodiscard]] FieldView view() const;
  struct CompactLocation {
    std::size_t record, offset;
  };
  [[nodiscard]] CompactLocation compact_location(std::size_t offset) const;

  GridShape m_shape;
  FieldPrecision m_precision;
  CompactSteps m_steps;
  std::optional<NarrowBand> m_band;
  std::vector<float> m_single;
  std::vector<CompactRecord> m_compact;
  std::vector<std::uint64_t> m_negative;  ///< one bit a cell
  FieldFacts m_facts;
};

}  // namespace musclebench

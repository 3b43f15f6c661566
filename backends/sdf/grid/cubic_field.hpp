#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "backends/sdf/grid/cell_map.hpp"
#include "backends/sdf/grid/cubic_cell.hpp"
#include "backends/sdf/grid/field_block.hpp"
#include "backends/sdf/grid/field_facts.hpp"
#include "backends/sdf/grid/grid_shape.hpp"

namespace musclebench {

struct FieldSample {
  double value_m = 0;
  Vec3 gradient = Vec3::Zero();  ///< of the polynomial: about, but not exactly, of unit length
};

/// A signed distance field over the box of a bone, cubic in each cell and continuous: negative inside, in metres. Made
/// by `build_field`. Its values are kept in single precision. Queries are const and safe from several threads.
class CubicField {
 public:
  explicit CubicField(const GridShape& shape);

  [[nodiscard]] const GridShape& shape() const { return m_shape; }
  [[nodiscard]] const FieldFacts& facts() const { return m_facts; }
  [[nodiscard]] FieldFacts& facts() { return m_facts; }

  /// Bytes of a field of this shape.
  [[nodiscard]] static double bytes_needed(const GridShape& shape);
  [[nodiscard]] std::size_t bytes() const;

  /// Nothing where the grid answers no point (GridShape::contains).
  [[nodiscard]] std::optional<double> value(const Vec3& point) const;
  [[nodiscard]] std::optional<FieldSample> sample(const Vec3& point) const;

  /// Which of many points are evaluated.
  enum class Wanted : std::uint8_t {
    known,         ///< those that the grid answers
    may_be_inside  ///< of those the ones that `may_be_negative` does not exclude
  };
  /// Appends to `block` the `wanted` ones of `nodes` (ascending indices into `positions`) from `first` on, mapped by
  /// `map`, and evaluates them when the block is full or all nodes were visited. Returns the index in `nodes`
  /// to go on at. `query` is the index in `nodes`. A position that is not a number is outside.
  std::size_t sample(const CellMap& map, std::span<const Vec3> positions, std::span<const int> nodes, std::size_t first,
                     Wanted wanted, FieldBlock& block) const;

  /// The same.
  [[nodiscard]] std::optional<CellPosition> locate(const Vec3& point) const;

  /// Whether the field may be negative somewhere in this cell; false proves that it is not.
  [[nodiscard]] bool may_be_negative(std::size_t cell) const {
    return ((m_negative[cell / 64] >> (cell % 64)) & 1U) != 0;
  }

  [[nodiscard]] CubicCell cell(std::size_t i, std::size_t j, std::size_t k) const;

  // To build, save and compare fields. Values are laid out as in GridShape.
  [[nodiscard]] double stored(std::size_t offset) const { return static_cast<double>(m_values[offset]); }
  void store(std::size_t offset, double value) { m_values[offset] = static_cast<float>(value); }
  [[nodiscard]] std::vector<float>& values() { return m_values; }
  [[nodiscard]] std::vector<std::uint64_t>& mask() { return m_negative; }
  [[nodiscard]] const std::vector<float>& values() const { return m_values; }
  [[nodiscard]] const std::vector<std::uint64_t>& mask() const { return m_negative; }

 private:
  [[nodiscard]] FieldView view() const;

  GridShape m_shape;
  std::vector<float> m_values;
  std::vector<std::uint64_t> m_negative;  ///< one bit a cell
  FieldFacts m_facts;
};

}  // namespace musclebench

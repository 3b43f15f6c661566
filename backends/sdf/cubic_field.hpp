#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "backends/sdf/cubic_cell.hpp"
#include "backends/sdf/grid_shape.hpp"

namespace musclebench {

enum class FieldPrecision : std::uint8_t { single_precision = 4, double_precision = 8 };  ///< bytes of a stored value

struct FieldSample {
  double value_m = 0;
  Vec3 gradient = Vec3::Zero();  ///< of the polynomial: about, but not exactly, of unit length
};

/// A signed distance field over the box of a bone, cubic in each cell and continuous: negative inside, in metres. Made
/// by `build_field`. On the border of its domain it is positive, so that nothing inside the bone is cut off. Queries
/// are const and safe from several threads.
class CubicField {
 public:
  CubicField(const GridShape& shape, FieldPrecision precision);

  [[nodiscard]] const GridShape& shape() const { return m_shape; }
  [[nodiscard]] FieldPrecision precision() const { return m_precision; }

  /// Bytes that a field of this shape holds.
  [[nodiscard]] static double bytes_needed(const GridShape& shape, FieldPrecision precision);
  [[nodiscard]] std::size_t bytes() const;

  /// Nothing outside the domain.
  [[nodiscard]] std::optional<double> value(const Vec3& point) const;
  [[nodiscard]] std::optional<FieldSample> sample(const Vec3& point) const;

  /// Whether the field may be negative somewhere in this cell; where it says no, it is not.
  [[nodiscard]] bool may_be_negative(std::size_t cell) const {
    return ((m_negative[cell / 64] >> (cell % 64)) & 1U) != 0;
  }

  [[nodiscard]] CubicCell cell(std::size_t i, std::size_t j, std::size_t k) const {
    return m_precision == FieldPrecision::single_precision ? gather(m_single, i, j, k) : gather(m_double, i, j, k);
  }

  /// The stored values (see GridShape), for those who make, save and compare fields.
  [[nodiscard]] double stored(std::size_t place) const {
    return m_precision == FieldPrecision::single_precision ? static_cast<double>(m_single[place]) : m_double[place];
  }
  void store(std::size_t place, double value) {
    if (m_precision == FieldPrecision::single_precision) {
      m_single[place] = static_cast<float>(value);
    } else {
      m_double[place] = value;
    }
  }
  [[nodiscard]] std::vector<float>& single_values() { return m_single; }
  [[nodiscard]] std::vector<double>& double_values() { return m_double; }
  [[nodiscard]] std::vector<std::uint64_t>& mask() { return m_negative; }
  [[nodiscard]] const std::vector<float>& single_values() const { return m_single; }
  [[nodiscard]] const std::vector<double>& double_values() const { return m_double; }
  [[nodiscard]] const std::vector<std::uint64_t>& mask() const { return m_negative; }

 private:
  struct Place {
    std::size_t i, j, k;
    Vec3 at;
  };

  template <typename Scalar>
  [[nodiscard]] CubicCell gather(const std::vector<Scalar>& values, std::size_t i, std::size_t j, std::size_t k) const {
    const Scalar* first = values.data() + m_shape.record(i, j, k);
    const std::size_t up_y = m_shape.row_stride();
    const std::size_t up_z = up_y * (m_shape.count(1) + 1);
    return CubicCell::gather<Scalar>({first, first + up_z, first + up_y, first + up_y + up_z});
  }
  [[nodiscard]] std::optional<Place> place(const Vec3& point) const;

  GridShape m_shape;
  FieldPrecision m_precision;
  Vec3 m_cells_per_m;
  std::vector<float> m_single;
  std::vector<double> m_double;
  std::vector<std::uint64_t> m_negative;  ///< one bit a cell
};

}  // namespace musclebench

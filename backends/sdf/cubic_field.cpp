#include "backends/sdf/cubic_field.hpp"

#include <algorithm>

namespace musclebench {

CubicField::CubicField(const GridShape& shape, FieldPrecision precision)
    : m_shape(shape), m_precision(precision), m_cells_per_m(shape.cell_size_m.cwiseInverse()) {
  if (precision == FieldPrecision::single_precision) {
    m_single.resize(shape.value_count());
  } else {
    m_double.resize(shape.value_count());
  }
  m_negative.resize(shape.mask_words());
}

double CubicField::bytes_needed(const GridShape& shape, FieldPrecision precision) {
  const double cells = static_cast<double>(shape.cells[0]) * shape.cells[1] * shape.cells[2];
  const double rows = static_cast<double>(shape.cells[1] + 1) * (shape.cells[2] + 1);
  const double row_values = 7.0 * shape.cells[0] + 5;
  return rows * row_values * static_cast<double>(precision) + cells / 8;
}

std::size_t CubicField::bytes() const {
  return m_single.size() * sizeof(float) + m_double.size() * sizeof(double) + m_negative.size() * sizeof(std::uint64_t);
}

std::optional<CubicField::Place> CubicField::place(const Vec3& point) const {
  const Vec3 local = (point - m_shape.lower_m).cwiseProduct(m_cells_per_m);
  std::array<std::size_t, 3> index{};
  Place result{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double along = local[static_cast<Eigen::Index>(axis)];
    if (!(along >= 0 && along <= m_shape.cells[axis])) {
      return std::nullopt;
    }
    index[axis] = std::min(static_cast<std::size_t>(along), m_shape.count(axis) - 1);
    result.at[static_cast<Eigen::Index>(axis)] = along - static_cast<double>(index[axis]);
  }
  result.i = index[0];
  result.j = index[1];
  result.k = index[2];
  return result;
}

std::optional<double> CubicField::value(const Vec3& point) const {
  const std::optional<Place> found = place(point);
  if (!found) {
    return std::nullopt;
  }
  return cell(found->i, found->j, found->k).value(found->at);
}

std::optional<FieldSample> CubicField::sample(const Vec3& point) const {
  const std::optional<Place> found = place(point);
  if (!found) {
    return std::nullopt;
  }
  FieldSample result;
  result.value_m = cell(found->i, found->j, found->k).value_and_gradient(found->at, result.gradient);
  result.gradient = result.gradient.cwiseProduct(m_cells_per_m);
  return result;
}

}  // namespace musclebench

#include "backends/sdf/cubic_field.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <utility>

namespace musclebench {

namespace {

/// Points that are looked up before their cells are evaluated.
constexpr std::size_t batch_size = 64;

}  // namespace

CubicField::CubicField(const GridShape& shape, FieldPrecision precision)
    : m_shape(shape),
      m_precision(precision),
      m_steps(compact_steps(shape.cell_size_m.x(), shape.cell_size_m.y(), shape.cell_size_m.z())),
      m_cells_per_m(shape.cell_size_m.cwiseInverse()) {
  allocate(shape.value_count(), shape.vertex_count());
}

CubicField::CubicField(const GridShape& shape, FieldPrecision precision, NarrowBand band)
    : m_shape(shape),
      m_precision(precision),
      m_steps(compact_steps(shape.cell_size_m.x(), shape.cell_size_m.y(), shape.cell_size_m.z())),
      m_cells_per_m(shape.cell_size_m.cwiseInverse()),
      m_band(std::move(band)) {
  allocate(GridShape::record_size * m_band->record_count(), m_band->record_count());
}

void CubicField::allocate(std::size_t values, std::size_t records) {
  switch (m_precision) {
    case FieldPrecision::single_precision:
      m_single.resize(values);
      break;
    case FieldPrecision::double_precision:
      m_double.resize(values);
      break;
    case FieldPrecision::compact:
      m_compact.resize(records);
      break;
  }
  m_negative.resize(m_shape.mask_words());
}

double CubicField::bytes_needed(const GridShape& shape, FieldPrecision precision) {
  const double cells = static_cast<double>(shape.cells[0]) * shape.cells[1] * shape.cells[2];
  const double rows = static_cast<double>(shape.cells[1] + 1) * (shape.cells[2] + 1);
  const double row_bytes = precision == FieldPrecision::compact
                               ? (1.0 + shape.cells[0]) * static_cast<double>(sizeof(CompactRecord))
                               : (7.0 * shape.cells[0] + 5) * static_cast<double>(precision);
  return rows * row_bytes + cells / 8;
}

std::size_t CubicField::bytes() const {
  return m_single.size() * sizeof(float) + m_double.size() * sizeof(double) + m_compact.size() * sizeof(CompactRecord) +
         m_negative.size() * sizeof(std::uint64_t) + (m_band ? m_band->bytes() : 0);
}

std::optional<std::size_t> CubicField::record(std::size_t i, std::size_t j, std::size_t k) const {
  if (!m_band) {
    return m_shape.record(i, j, k);
  }
  const std::size_t vertex = m_shape.vertex_index(i, j, k);
  return m_band->has_record(vertex) ? std::optional(GridShape::record_size * m_band->record(vertex)) : std::nullopt;
}

CubicField::CompactPlace CubicField::compact_place(std::size_t place) const {
  if (m_band) {
    return {place / GridShape::record_size, place % GridShape::record_size};
  }
  const std::size_t row = place / m_shape.row_stride();
  const std::size_t in_row = place % m_shape.row_stride();
  return {row * (m_shape.count(0) + 1) + in_row / GridShape::record_size, in_row % GridShape::record_size};
}

double CubicField::stored(std::size_t place) const {
  if (m_precision == FieldPrecision::single_precision) {
    return static_cast<double>(m_single[place]);
  }
  if (m_precision == FieldPrecision::double_precision) {
    return m_double[place];
  }
  const auto [record, offset] = compact_place(place);
  const CompactRecord& values = m_compact[record];
  return static_cast<double>(offset == 0 ? values.own : compact_value(values, offset - 1, m_steps));
}

void CubicField::store(std::size_t place, double value) {
  if (m_precision == FieldPrecision::single_precision) {
    m_single[place] = static_cast<float>(value);
  } else if (m_precision == FieldPrecision::double_precision) {
    m_double[place] = value;
  } else if (const auto [record, offset] = compact_place(place); offset == 0) {
    m_compact[record].own = static_cast<float>(value);
  } else {
    store_compact(m_compact[record], offset - 1, value, m_steps);
  }
}

CubicCell CubicField::cell(std::size_t i, std::size_t j, std::size_t k) const {
  const std::array<const void*, 4> run = runs(i, j, k);
  if (m_precision == FieldPrecision::single_precision) {
    const auto of = [&](std::size_t r) { return static_cast<const float*>(run[r]); };
    return CubicCell::gather<float>({of(0), of(1), of(2), of(3)});
  }
  if (m_precision == FieldPrecision::double_precision) {
    const auto of = [&](std::size_t r) { return static_cast<const double*>(run[r]); };
    return CubicCell::gather<double>({of(0), of(1), of(2), of(3)});
  }
  std::array<std::array<float, 2 * GridShape::record_size>, 4> values{};
  for (std::size_t r = 0; r < 4; ++r) {
    const auto* records = static_cast<const CompactRecord*>(run[r]);
    for (std::size_t n = 0; n < 2 * GridShape::record_size; ++n) {
      const CompactRecord& record = records[n / GridShape::record_size];
      const std::size_t offset = n % GridShape::record_size;
      values[r][n] = offset == 0 ? record.own : compact_value(record, offset - 1, m_steps);
    }
  }
  return CubicCell::gather<float>({values[0].data(), values[1].data(), values[2].data(), values[3].data()});
}

std::optional<CellPlace> CubicField::place(const Vec3& point) const {
  const Vec3 local = (point - m_shape.lower_m).cwiseProduct(m_cells_per_m);
  std::array<std::size_t, 3> index{};
  CellPlace result{};
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
  const std::optional<FieldSample> found = sample(point);
  return found ? std::optional(found->value_m) : std::nullopt;
}

std::optional<FieldSample> CubicField::sample(const Vec3& point) const {
  const std::optional<CellPlace> found = place(point);
  if (!found || !knows(m_shape.cell(found->i, found->j, found->k))) {
    return std::nullopt;
  }
  const CellQuery asked = query(*found);
  CellAnswer answer{};
  evaluate({&asked, 1}, {&answer, 1});
  const auto& [x, y, z] = answer.gradient;
  return FieldSample{answer.value, Vec3(x, y, z).cwiseProduct(m_cells_per_m)};
}

void CubicField::sample(std::span<const Vec3> points, std::span<FieldSample> samples) const {
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  std::array<CellQuery, batch_size> queries;
  std::array<CellAnswer, batch_size> answers;
  std::array<std::size_t, batch_size> asker;
  for (std::size_t first = 0; first < points.size(); first += batch_size) {
    const std::size_t end = std::min(first + batch_size, points.size());
    std::size_t count = 0;
    for (std::size_t p = first; p < end; ++p) {
      const std::optional<CellPlace> found = place(points[p]);
      if (found && knows(m_shape.cell(found->i, found->j, found->k))) {
        queries[count] = query(*found);
        asker[count++] = p;
      } else {
        samples[p] = {nan, Vec3::Constant(nan)};
      }
    }
    evaluate({queries.data(), count}, answers);
    for (std::size_t n = 0; n < count; ++n) {
      const auto& [x, y, z] = answers[n].gradient;
      samples[asker[n]] = {answers[n].value, Vec3(x, y, z).cwiseProduct(m_cells_per_m)};
    }
  }
}

}  // namespace musclebench

#include "backends/sdf/grid/cubic_field.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <utility>

#include "backends/sdf/grid/cubic_kernel.hpp"
#include "backends/sdf/grid/gather_nodes.hpp"

namespace musclebench {

CubicField::CubicField(const GridShape& shape, FieldPrecision precision)
    : m_shape(shape),
      m_precision(precision),
      m_steps(compact_steps(shape.cell_size_m.x(), shape.cell_size_m.y(), shape.cell_size_m.z())) {
  allocate(shape.value_count(), shape.vertex_count());
}

CubicField::CubicField(const GridShape& shape, FieldPrecision precision, NarrowBand band)
    : m_shape(shape),
      m_precision(precision),
      m_steps(compact_steps(shape.cell_size_m.x(), shape.cell_size_m.y(), shape.cell_size_m.z())),
      m_band(std::move(band)) {
  allocate(GridShape::record_size * m_band->record_count(), m_band->record_count());
}

void CubicField::allocate(std::size_t values, std::size_t records) {
  switch (m_precision) {
    case FieldPrecision::single_precision:
      m_single.resize(values);
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
  return m_single.size() * sizeof(float) + m_compact.size() * sizeof(CompactRecord) +
         m_negative.size() * sizeof(std::uint64_t) + (m_band ? m_band->bytes() : 0);
}

std::optional<std::size_t> CubicField::record(std::size_t i, std::size_t j, std::size_t k) const {
  if (!m_band) {
    return m_shape.record(i, j, k);
  }
  const std::size_t vertex = m_shape.vertex_index(i, j, k);
  return m_band->has_record(vertex) ? std::optional(GridShape::record_size * m_band->record(vertex)) : std::nullopt;
}

CubicField::CompactLocation CubicField::compact_location(std::size_t offset) const {
  if (m_band) {
    return {offset / GridShape::record_size, offset % GridShape::record_size};
  }
  const std::size_t row = offset / m_shape.row_stride();
  const std::size_t in_row = offset % m_shape.row_stride();
  return {row * (m_shape.count(0) + 1) + in_row / GridShape::record_size, in_row % GridShape::record_size};
}

double CubicField::stored(std::size_t offset) const {
  if (m_precision == FieldPrecision::single_precision) {
    return static_cast<double>(m_single[offset]);
  }
  const auto [record, in_record] = compact_location(offset);
  const CompactRecord& values = m_compact[record];
  return static_cast<double>(in_record == 0 ? values.own : compact_value(values, in_record - 1, m_steps));
}

void CubicField::store(std::size_t offset, double value) {
  if (m_precision == FieldPrecision::single_precision) {
    m_single[offset] = static_cast<float>(value);
  } else if (const auto [record, in_record] = compact_location(offset); in_record == 0) {
    m_compact[record].own = static_cast<float>(value);
  } else {
    store_compact(m_compact[record], in_record - 1, value, m_steps);
  }
}

FieldView CubicField::view() const {
  const void* values = m_single.data();
  if (m_precision == FieldPrecision::compact) values = m_compact.data();
  const Vec3& size = m_shape.cell_size_m;
  const std::array<std::int32_t, 3>& cells = m_shape.cells;
  return {m_precision,
          values,
          m_band ? &*m_band : nullptr,
          {static_cast<double>(cells[0]), static_cast<double>(cells[1]), static_cast<double>(cells[2])},
          {1 / size.x(), 1 / size.y(), 1 / size.z()},
          m_steps};
}

CubicCell CubicField::cell(std::size_t i, std::size_t j, std::size_t k) const {
  const auto begin = [&](std::size_t run) { return *record(i, j + run / 2, k + run % 2); };
  if (m_precision == FieldPrecision::single_precision) {
    const auto of = [&](std::size_t run) { return m_single.data() + begin(run); };
    return CubicCell::gather<float>({of(0), of(1), of(2), of(3)});
  }
  std::array<std::array<double, CubicCell::run_size>, 4> values{};
  for (std::size_t run = 0; run < values.size(); ++run) {
    for (std::size_t n = 0; n < CubicCell::run_size; ++n) {
      values[run][n] = stored(begin(run) + n);
    }
  }
  return CubicCell::gather<double>({values[0].data(), values[1].data(), values[2].data(), values[3].data()});
}

std::optional<CellPosition> CubicField::locate(const Vec3& point) const {
  const Vec3 cells = CellMap(m_shape).apply(point - m_shape.lower_m);
  return m_shape.contains(cells) ? std::optional(m_shape.locate(cells)) : std::nullopt;
}

std::optional<double> CubicField::value(const Vec3& point) const {
  const std::optional<FieldSample> found = sample(point);
  return found ? std::optional(found->value_m) : std::nullopt;
}

std::optional<FieldSample> CubicField::sample(const Vec3& point) const {
  static constexpr std::array<int, 1> only{0};
  const Vec3 from_corner = point - m_shape.lower_m;
  FieldBlock block;
  sample(CellMap(m_shape), {&from_corner, 1}, only, 0, Wanted::known, block);
  if (block.count == 0) {
    return std::nullopt;
  }
  return FieldSample{block.value_m[0], block.slope(0)};
}

std::size_t CubicField::sample(const CellMap& map, std::span<const Vec3> positions, std::span<const int> nodes,
                               std::size_t first, Wanted wanted, FieldBlock& block) const {
  const std::uint64_t* bits = m_band ? m_band->cell_bits().data() : nullptr;
  if (wanted == Wanted::may_be_inside) {
    bits = m_negative.data();
  }
  const FieldView field = view();
  const std::size_t next = first + gather_nodes(m_shape, map, bits, positions, nodes.subspan(first), first, block);
  evaluate_block(field, block);
  return next;
}

}  // namespace musclebench

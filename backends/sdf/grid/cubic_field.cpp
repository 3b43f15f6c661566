#include "backends/sdf/grid/cubic_field.hpp"

#include <array>
#include <span>

#include "backends/sdf/grid/cubic_kernel.hpp"
#include "backends/sdf/grid/gather_nodes.hpp"

namespace musclebench {

CubicField::CubicField(const GridShape& shape)
    : m_shape(shape), m_values(shape.value_count()), m_negative(shape.mask_words()) {}

double CubicField::bytes_needed(const GridShape& shape) {
  const double cells = static_cast<double>(shape.cells[0]) * shape.cells[1] * shape.cells[2];
  const double rows = static_cast<double>(shape.cells[1] + 1) * (shape.cells[2] + 1);
  return rows * (7.0 * shape.cells[0] + 5) * static_cast<double>(sizeof(float)) + cells / 8;
}

std::size_t CubicField::bytes() const {
  return m_values.size() * sizeof(float) + m_negative.size() * sizeof(std::uint64_t);
}

FieldView CubicField::view() const {
  const Vec3& size = m_shape.cell_size_m;
  const std::array<std::int32_t, 3>& cells = m_shape.cells;
  return {m_values.data(),
          {static_cast<double>(cells[0]), static_cast<double>(cells[1]), static_cast<double>(cells[2])},
          {1 / size.x(), 1 / size.y(), 1 / size.z()}};
}

CubicCell CubicField::cell(std::size_t i, std::size_t j, std::size_t k) const {
  const auto run = [&](std::size_t n) { return m_values.data() + m_shape.record(i, j + n / 2, k + n % 2); };
  return CubicCell::gather({run(0), run(1), run(2), run(3)});
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
  const std::uint64_t* bits = wanted == Wanted::may_be_inside ? m_negative.data() : nullptr;
  const FieldView field = view();
  const std::size_t next = first + gather_nodes(m_shape, map, bits, positions, nodes.subspan(first), first, block);
  evaluate_block(field, block);
  return next;
}

}  // namespace musclebench

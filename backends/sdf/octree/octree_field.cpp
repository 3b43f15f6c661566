#include "backends/sdf/octree/octree_field.hpp"

#include <algorithm>
#include <utility>

#include "backends/sdf/grid/gather_nodes.hpp"
#include "backends/sdf/octree/octree_entry.hpp"

namespace musclebench {

OctreeField::OctreeField(const OctreeShape& shape, const OctreeQuality& quality, std::vector<std::uint32_t> entries,
                         std::vector<float> coefficients)
    : m_shape(shape), m_quality(quality), m_entries(std::move(entries)), m_coefficients(std::move(coefficients)) {
  m_leaves = static_cast<std::size_t>(std::count_if(m_entries.begin(), m_entries.end(), [](std::uint32_t entry) {
    const octree_entry::Kind kind = octree_entry::kind_of(entry);
    return kind == octree_entry::Kind::quadratic || kind == octree_entry::Kind::cubic;
  }));
}

OctreeView OctreeField::view() const {
  const std::array<std::int32_t, 3>& roots = m_shape.roots;
  return {m_entries.data(),
          m_coefficients.data(),
          {static_cast<double>(roots[0]), static_cast<double>(roots[1]), static_cast<double>(roots[2])},
          m_shape.root_edge_m,
          m_quality.excess_m,
          m_quality.sign_error_distance_m};
}

std::size_t OctreeField::sample(const CellMap& map, std::span<const Vec3> positions, std::span<const int> nodes,
                                std::size_t first, FieldBlock& block, LeafBlock& leaves) const {
  const OctreeView field = view();
  const std::size_t next =
      first + gather_nodes(m_shape.grid(), map, nullptr, positions, nodes.subspan(first), first, block);
  evaluate_block(field, block, leaves);
  return next;
}

void OctreeField::clear(const FieldBlock& block, const LeafBlock& leaves,
                        FieldBlock::Lanes<double>& clearance_m) const {
  clear_block(view(), block, leaves, clearance_m);
}

bool OctreeField::sample(const Vec3& point, FieldBlock& block, LeafBlock& leaves) const {
  static constexpr std::array<int, 1> only{0};
  const Vec3 from_corner = point - m_shape.lower_m;
  sample(CellMap(m_shape.grid()), {&from_corner, 1}, only, 0, block, leaves);
  return block.count > 0;
}

std::optional<OctreeField::Sample> OctreeField::sample(const Vec3& point) const {
  FieldBlock block;
  LeafBlock leaves;
  return sample(point, block, leaves) ? std::optional(Sample{block.value_m[0], block.slope(0)}) : std::nullopt;
}

std::optional<double> OctreeField::value(const Vec3& point) const {
  const std::optional<Sample> found = sample(point);
  return found ? std::optional(found->value_m) : std::nullopt;
}

double OctreeField::clearance_m(const Vec3& point) const {
  FieldBlock block;
  LeafBlock leaves;
  if (!sample(point, block, leaves)) {
    const GridShape grid = m_shape.grid();
    return grid.distance_m((point - grid.lower_m) / m_shape.root_edge_m) * (1 - 1e-9);
  }
  FieldBlock::Lanes<double> clearance_m;
  clear(block, leaves, clearance_m);
  return clearance_m[0];
}

}  // namespace musclebench

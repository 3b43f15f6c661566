#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "backends/voxel/cell_clearances.hpp"
#include "core/base/grid_index.hpp"
#include "core/bvh/triangle_bvh.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A grid as its kernel reads it: a bit a cell of those that are kept, from `first` to before `end`.
struct VoxelView {
  const std::uint64_t* bits;
  Vec3 first, end, counts;
  Vec3 cell_size_m;
  double rounding_m;  ///< of a point that is mapped to cells
};

/// Occupancy grid of a surface, one bit a cell: set where the cell touches the surface or lies inside it. So every
/// point inside the surface is in a set cell. It may keep a box of its cells only, each as in the whole grid.
class VoxelGrid {
 public:
  /// `cells` along each axis of the surface's bounding box, so that cells are not cubes (as in the paper's public
  /// code); or, if `voxel_size_m` > 0, cubes of that size. `tree` is that of `surface`; of one that is not closed each
  /// cell is asked for its own winding number, which takes longer. Kept are the cells that meet `expected`, at least
  /// one. Throws InputError, which names `name`, when the grid needs more memory than is available.
  VoxelGrid(const TriangleMesh& surface, const TriangleBvh& tree, bool is_closed, int cells, double voxel_size_m,
            const std::string& name, const Eigen::AlignedBox3d& expected = unbounded_box());
  /// Of a closed surface.
  VoxelGrid(const TriangleMesh& surface, int cells, double voxel_size_m, const std::string& name)
      : VoxelGrid(surface, TriangleBvh(surface), true, cells, voxel_size_m, name) {}

  /// Makes `clearances` available.
  void find_clearances();
  [[nodiscard]] const CellClearances& clearances() const { return m_clearances; }

  [[nodiscard]] VoxelView view() const {
    return {m_bits.data(), m_first_real, m_end_real, m_counts_real, m_cell_size_m, m_rounding_m};
  }
  [[nodiscard]] Vec3 point(const Vec3& scaled) const { return m_lower + m_cell_size_m.cwiseProduct(scaled); }

  [[nodiscard]] const Vec3& lower() const { return m_lower; }
  [[nodiscard]] const Vec3& cell_size_m() const { return m_cell_size_m; }
  [[nodiscard]] const std::array<int, 3>& counts() const { return m_counts; }
  /// Of all cells.
  [[nodiscard]] double kept_share() const { return (m_end_real - m_first_real).prod() / m_counts_real.prod(); }
  [[nodiscard]] std::size_t bytes() const { return m_bits.size() * sizeof(std::uint64_t) + m_clearances.bytes(); }

 private:
  enum class Cell : std::uint8_t { unknown, border, inside, outside };

  /// Of a cell that is kept.
  [[nodiscard]] std::size_t index(int x, int y, int z) const {
    return m_cells.index(static_cast<std::size_t>(x - m_first[0]), static_cast<std::size_t>(y - m_first[1]),
                         static_cast<std::size_t>(z - m_first[2]));
  }
  void keep_cells_in(const Eigen::AlignedBox3d& expected);
  void size_cells(const TriangleMesh& surface, int cells, double voxel_size_m);
  void mark_border(const TriangleMesh& surface, std::vector<Cell>& states) const;
  void mark_regions(const TriangleBvh& tree, std::vector<Cell>& states) const;
  void mark_cells_of_open(const TriangleBvh& tree, std::vector<Cell>& states) const;
  void flood(const std::array<int, 3>& seed, Cell region, std::vector<Cell>& states) const;

  Vec3 m_lower = Vec3::Zero();
  double m_rounding_m = 0;  ///< of a point that is mapped to cells
  Vec3 m_cell_size_m = Vec3::Ones();
  Vec3 m_counts_real = Vec3::Zero();
  std::array<int, 3> m_counts{};
  // The cells that are kept, from the first to before the end.
  std::array<int, 3> m_first{};
  std::array<int, 3> m_end{};
  Vec3 m_first_real = Vec3::Zero();
  Vec3 m_end_real = Vec3::Zero();
  GridIndex m_cells;
  std::vector<std::uint64_t> m_bits;
  CellClearances m_clearances;
};

}  // namespace musclebench

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/grid_index.hpp"
#include "core/bvh/triangle_bvh.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Occupancy grid of a closed surface, one bit a cell: set where the cell touches the surface or lies inside it. So
/// every point inside the surface is in a set cell.
class VoxelGrid {
 public:
  /// `cells` along each axis of the surface's bounding box, so that cells are not cubes (as in the paper's public
  /// code); or, if `voxel_size_m` > 0, cubes of that size. `surface` is closed. Throws InputError, which names `name`,
  /// when the grid needs more memory than is available. `tree` is
  /// that of the surface.
  VoxelGrid(const TriangleMesh& surface, const TriangleBvh& tree, int cells, double voxel_size_m,
            const std::string& name);
  VoxelGrid(const TriangleMesh& surface, int cells, double voxel_size_m, const std::string& name)
      : VoxelGrid(surface, TriangleBvh(surface), cells, voxel_size_m, name) {}

  /// `scaled` is a point in units of cells from `lower()`.
  [[nodiscard]] bool contains_scaled(const Vec3& scaled) const {
    // Comparisons that a NaN fails.
    if (!(scaled.x() >= 0 && scaled.y() >= 0 && scaled.z() >= 0 && scaled.x() < m_counts_real.x() &&
          scaled.y() < m_counts_real.y() && scaled.z() < m_counts_real.z())) {
      return false;
    }
    const std::size_t cell =
        index(static_cast<int>(scaled.x()), static_cast<int>(scaled.y()), static_cast<int>(scaled.z()));
    return ((m_bits[cell / 64] >> (cell % 64)) & 1U) != 0;
  }
  [[nodiscard]] bool contains(const Vec3& point) const {
    return contains_scaled((point - m_lower).cwiseQuotient(m_cell_size_m));
  }

  [[nodiscard]] const Vec3& lower() const { return m_lower; }
  [[nodiscard]] const Vec3& cell_size_m() const { return m_cell_size_m; }
  [[nodiscard]] const std::array<int, 3>& counts() const { return m_counts; }
  [[nodiscard]] std::size_t bytes() const { return m_bits.size() * sizeof(std::uint64_t); }

 private:
  enum class Cell : std::uint8_t { unknown, border, inside, outside };

  [[nodiscard]] std::size_t index(int x, int y, int z) const {
    return m_cells.index(static_cast<std::size_t>(x), static_cast<std::size_t>(y), static_cast<std::size_t>(z));
  }
  void size_cells(const TriangleMesh& surface, int cells, double voxel_size_m);
  void mark_border(const TriangleMesh& surface, std::vector<Cell>& states) const;
  void mark_inside(const TriangleBvh& tree, std::vector<Cell>& states) const;
  void flood(const std::array<int, 3>& seed, Cell region, std::vector<Cell>& states) const;

  Vec3 m_lower = Vec3::Zero();
  Vec3 m_cell_size_m = Vec3::Ones();
  Vec3 m_counts_real = Vec3::Zero();
  std::array<int, 3> m_counts{};
  GridIndex m_cells;
  std::vector<std::uint64_t> m_bits;
};

}  // namespace musclebench

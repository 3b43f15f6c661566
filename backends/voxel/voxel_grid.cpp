#include "backends/voxel/voxel_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/base/system_memory.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// Whether the projections of triangle and box on `axis` overlap; the box is centred at the origin.
bool overlaps_along(const Vec3& axis, const std::array<Vec3, 3>& corners, const Vec3& half) {
  const double p0 = axis.dot(corners[0]);
  const double p1 = axis.dot(corners[1]);
  const double p2 = axis.dot(corners[2]);
  const double reach = half.dot(axis.cwiseAbs());
  return std::min({p0, p1, p2}) <= reach && std::max({p0, p1, p2}) >= -reach;
}

/// Separating axis test of a triangle and a box (Akenine-Moeller 2001): the box's axes, the triangle's normal and the
/// nine cross products of edges. An axis of length 0 separates nothing, so degenerate triangles are handled
/// conservatively.
bool triangle_touches_box(const std::array<Vec3, 3>& triangle, const Vec3& centre, const Vec3& half) {
  const std::array<Vec3, 3> corners = {triangle[0] - centre, triangle[1] - centre, triangle[2] - centre};
  const std::array<Vec3, 3> edges = {corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]};
  for (int axis = 0; axis < 3; ++axis) {
    if (!overlaps_along(Vec3::Unit(axis), corners, half)) {
      return false;
    }
  }
  if (!overlaps_along(edges[0].cross(edges[1]), corners, half)) {
    return false;
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const Vec3& edge : edges) {
      if (!overlaps_along(Vec3::Unit(axis).cross(edge), corners, half)) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace

VoxelGrid::VoxelGrid(const TriangleMesh& surface, const TriangleBvh& tree, bool is_closed, int cells,
                     double voxel_size_m, const std::string& name, const Eigen::AlignedBox3d& expected) {
  size_cells(surface, cells, voxel_size_m);
  const double total = m_counts_real.prod();
  constexpr double bytes_while_building = 2 * sizeof(Cell) + 1.0 / 8;
  if (!(total < 1e18)) {
    throw InputError(name, fmt::format("asks for {:.3g} voxels; choose larger cells", total));
  }
  require_memory(static_cast<std::size_t>(total * bytes_while_building), name, "choose fewer or larger cells");
  keep_cells_in(expected);

  std::vector<Cell> states(m_cells.size(), Cell::unknown);
  mark_border(surface, states);
  if (is_closed) {
    mark_regions(tree, states);
  } else {
    mark_cells_of_open(tree, states);
  }
  m_bits.assign((states.size() + 63) / 64, 0);
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (states[i] == Cell::border || states[i] == Cell::inside) {
      m_bits[i / 64] |= std::uint64_t{1} << (i % 64);
    }
  }
}

void VoxelGrid::size_cells(const TriangleMesh& surface, int cells, double voxel_size_m) {
  const Eigen::AlignedBox3d box = bounding_box(surface.vertices);
  const Vec3& lower = box.min();
  const Vec3& upper = box.max();
  // Padded, so that rounding puts no point of the surface outside the grid and a flat bone has cells of positive size.
  const Vec3 padding = Vec3::Constant(1e-9 * (upper - lower).norm()) +
                       4 * std::numeric_limits<double>::epsilon() * lower.cwiseAbs().cwiseMax(upper.cwiseAbs());
  m_lower = lower - padding;
  m_rounding_m = padding.norm();
  const Vec3 extent = upper - lower + 2 * padding;
  if (voxel_size_m > 0) {
    m_cell_size_m.setConstant(voxel_size_m);
    m_counts_real = (extent / voxel_size_m).array().floor() + 1;
    m_lower -= 0.5 * (m_counts_real * voxel_size_m - extent);
  } else {
    m_cell_size_m = extent / cells;
    m_counts_real.setConstant(cells);
  }
  for (int axis = 0; axis < 3; ++axis) {
    m_counts[axis] = m_counts_real[axis] < 1e9 ? static_cast<int>(m_counts_real[axis]) : 0;
  }
}

void VoxelGrid::find_clearances() {
  m_clearances = CellClearances(m_cells, m_cell_size_m, m_counts_real.cwiseProduct(m_cell_size_m).norm(), m_bits);
}

void VoxelGrid::keep_cells_in(const Eigen::AlignedBox3d& expected) {
  for (int axis = 0; axis < 3; ++axis) {
    const double count = m_counts_real[axis];
    const double low = std::floor((expected.min()[axis] - m_lower[axis]) / m_cell_size_m[axis]);
    const double high = std::ceil((expected.max()[axis] - m_lower[axis]) / m_cell_size_m[axis]);
    m_first_real[axis] = std::clamp(low, 0.0, count - 1);
    m_end_real[axis] = std::clamp(high, m_first_real[axis] + 1, count);
    m_first[axis] = static_cast<int>(m_first_real[axis]);
    m_end[axis] = static_cast<int>(m_end_real[axis]);
    m_cells.count[axis] = static_cast<std::size_t>(m_end[axis] - m_first[axis]);
  }
}

void VoxelGrid::mark_border(const TriangleMesh& surface, std::vector<Cell>& states) const {
  // Cells are tested slightly enlarged, so that rounding misses none.
  const Vec3 half = (0.5 + 1e-9) * m_cell_size_m;
  for (const Triangle& triangle : surface.triangles) {
    const std::array<Vec3, 3> corners = {surface.vertices[triangle[0]], surface.vertices[triangle[1]],
                                         surface.vertices[triangle[2]]};
    const Vec3 low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]) - m_lower;
    const Vec3 high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]) - m_lower;
    std::array<int, 3> first{};
    std::array<int, 3> last{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell = [&](double along_m, double slack) {
        return std::clamp(static_cast<int>(along_m / m_cell_size_m[axis] + slack), 0, m_counts[axis] - 1);
      };
      first[axis] = std::max(cell(low[axis], -1e-9), m_first[axis]);
      last[axis] = std::min(cell(high[axis], 1e-9), m_end[axis] - 1);
    }
    for (int z = first[2]; z <= last[2]; ++z) {
      for (int y = first[1]; y <= last[1]; ++y) {
        for (int x = first[0]; x <= last[0]; ++x) {
          Cell& state = states[index(x, y, z)];
          const Vec3 centre = m_lower + m_cell_size_m.cwiseProduct(Vec3(x + 0.5, y + 0.5, z + 0.5));
          if (state != Cell::border && triangle_touches_box(corners, centre, half)) {
            state = Cell::border;
          }
        }
      }
    }
  }
}

/// The cells that a closed surface does not touch form connected regions, each wholly inside or outside: one winding
/// number decides. (A flood fill from a corner of the grid would take every enclosed cavity for inside.)
void VoxelGrid::mark_regions(const TriangleBvh& tree, std::vector<Cell>& states) const {
  for (int z = m_first[2]; z < m_end[2]; ++z) {
    for (int y = m_first[1]; y < m_end[1]; ++y) {
      for (int x = m_first[0]; x < m_end[0]; ++x) {
        if (states[index(x, y, z)] == Cell::unknown) {
          const Vec3 centre = m_lower + m_cell_size_m.cwiseProduct(Vec3(x + 0.5, y + 0.5, z + 0.5));
          flood({x, y, z}, tree.winding_number(centre) > 0.5 ? Cell::inside : Cell::outside, states);
        }
      }
    }
  }
}

/// Through a hole the inside goes on into the outside, so each cell is asked for itself. The next ones beyond those
/// inside may hold points that are: elsewhere the surface lies between the two.
void VoxelGrid::mark_cells_of_open(const TriangleBvh& tree, std::vector<Cell>& states) const {
  const auto for_each_kept = [&](const auto& visit) {
    for (int z = m_first[2]; z < m_end[2]; ++z) {
      for (int y = m_first[1]; y < m_end[1]; ++y) {
        for (int x = m_first[0]; x < m_end[0]; ++x) visit(x, y, z);
      }
    }
  };
  for_each_kept([&](int x, int y, int z) {
    Cell& state = states[index(x, y, z)];
    if (state != Cell::unknown) return;
    const Vec3 centre = m_lower + m_cell_size_m.cwiseProduct(Vec3(x + 0.5, y + 0.5, z + 0.5));
    const bool is_inside = tree.winding_number(centre) > 0.5;
    state = is_inside ? Cell::inside : Cell::outside;
  });
  for_each_kept([&](int x, int y, int z) {
    if (states[index(x, y, z)] != Cell::inside) return;
    for (int nz = std::max(z - 1, m_first[2]); nz <= std::min(z + 1, m_end[2] - 1); ++nz) {
      for (int ny = std::max(y - 1, m_first[1]); ny <= std::min(y + 1, m_end[1] - 1); ++ny) {
        for (int nx = std::max(x - 1, m_first[0]); nx <= std::min(x + 1, m_end[0] - 1); ++nx) {
          Cell& neighbour = states[index(nx, ny, nz)];
          if (neighbour == Cell::outside) neighbour = Cell::border;
        }
      }
    }
  });
}

/// Scan-line flood fill: fills whole runs along x, so that the stack holds runs instead of cells.
void VoxelGrid::flood(const std::array<int, 3>& seed, Cell region, std::vector<Cell>& states) const {
  const auto unknown = [&](int x, int y, int z) { return states[index(x, y, z)] == Cell::unknown; };
  std::vector<std::array<int, 3>> front = {seed};
  while (!front.empty()) {
    const auto [x, y, z] = front.back();
    front.pop_back();
    if (!unknown(x, y, z)) {
      continue;
    }
    int first = x;
    int last = x;
    while (first > m_first[0] && unknown(first - 1, y, z)) {
      --first;
    }
    while (last + 1 < m_end[0] && unknown(last + 1, y, z)) {
      ++last;
    }
    std::fill_n(states.begin() + static_cast<std::ptrdiff_t>(index(first, y, z)), last - first + 1, region);
    for (const auto& [dy, dz] : {std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)}) {
      const int ny = y + dy;
      const int nz = z + dz;
      if (ny < m_first[1] || nz < m_first[2] || ny >= m_end[1] || nz >= m_end[2]) {
        continue;
      }
      for (int nx = first; nx <= last; ++nx) {
        if (unknown(nx, ny, nz) && (nx == first || !unknown(nx - 1, ny, nz))) {
          front.push_back({nx, ny, nz});
        }
      }
    }
  }
}

}  // namespace musclebench

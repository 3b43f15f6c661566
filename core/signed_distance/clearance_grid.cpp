#include "core/signed_distance/clearance_grid.hpp"

#include <cmath>
#include <cstddef>
#include <limits>

namespace musclebench {

namespace {

/// Along the longest side of the box; about 2 mm on a pelvis. Larger cubes give weaker bounds near the surface, smaller
/// ones take longer to fill and gain little.
constexpr double most_cubes_along = 96;
/// Smallest cube in mean triangle sizes: a coarse mesh, whose searches are fast, needs no fine grid.
constexpr double triangles_along_cube = 3;
/// Largest block of cubes, along an axis, that may be filled from the distance of its middle.
constexpr std::size_t block_size = 16;
/// A block is not subdivided where every cube keeps this fraction of the distance of the block's middle.
constexpr double kept_fraction = 0.7;
/// In steps: more than the rounding error of a stored distance, of a point's coordinates in the grid and of its
/// distance from the cube's centre.
constexpr double rounding = 0.01;

}  // namespace

/// Fills blocks of cubes recursively, as an octree.
class ClearanceGrid::Filling {
 public:
  Filling(const SignedSurface& surface, ClearanceGrid& grid) : m_surface(surface), m_grid(grid) {}

  /// `first`: the cube at the block's lower corner; `size`: its cubes along an axis.
  void fill(const GridIndex::Coordinates& first, std::size_t size) {
    const Vec3 middle =
        Vec3(static_cast<double>(first[0]), static_cast<double>(first[1]), static_cast<double>(first[2])) +
        Vec3::Constant(0.5 * static_cast<double>(size));
    const Vec3 point = m_grid.m_lower_m + m_grid.m_edge_m * middle;
    const ClosestPoint closest = m_surface.tree().closest_point_from(point, m_nearest);
    m_nearest = closest.triangle;
    const bool inside = m_surface.is_inside(point, closest);
    const double distance = closest.distance_m * m_grid.m_cubes_per_m;
    const double to_centres = 0.5 * std::sqrt(3.0) * static_cast<double>(size - 1);
    if (size == 1 || (distance > to_centres && (inside || distance - to_centres >= kept_fraction * distance))) {
      if (!inside) {
        store(first, size, middle, distance);
      }
      return;
    }
    const std::size_t half = size / 2;
    const GridIndex::Coordinates& count = m_grid.m_cubes.count;
    for (std::size_t part = 0; part < 8; ++part) {
      const GridIndex::Coordinates corner{first[0] + (part & 1U) * half, first[1] + (part >> 1U & 1U) * half,
                                          first[2] + (part >> 2U) * half};
      if (corner[0] < count[0] && corner[1] < count[1] && corner[2] < count[2]) {
        fill(corner, half);
      }
    }
  }

 private:
  void store(const GridIndex::Coordinates& first, std::size_t size, const Vec3& middle, double distance) {
    constexpr double most = std::numeric_limits<std::uint16_t>::max();
    GridIndex::Coordinates end{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      end[axis] = std::min(first[axis] + size, m_grid.m_cubes.count[axis]);
    }
    for_each_in(first, end, [&](std::size_t i, std::size_t j, std::size_t k) {
      const Vec3 centre =
          Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)) + Vec3::Constant(0.5);
      const double kept = distance - (centre - middle).norm();
      m_grid.m_steps[m_grid.m_cubes.index(i, j, k)] =
          static_cast<std::uint16_t>(std::clamp(steps_per_cube * kept - rounding, 0.0, most));
    });
  }

  const SignedSurface& m_surface;
  ClearanceGrid& m_grid;
  int m_nearest = 0;  ///< triangle of the last query
};

ClearanceGrid::ClearanceGrid(const SignedSurface& surface, const Eigen::AlignedBox3d& box, double triangle_size_m,
                             [[maybe_unused]] int threads) {
  const double edge_m = std::max(box.sizes().maxCoeff() / most_cubes_along, triangles_along_cube * triangle_size_m);
  if (!(edge_m > 0)) {
    return;
  }
  m_edge_m = edge_m;
  m_cubes_per_m = 1 / edge_m;
  GridIndex blocks;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto along = static_cast<Eigen::Index>(axis);
    m_cubes.count[axis] = static_cast<std::size_t>(std::max(std::ceil(box.sizes()[along] * m_cubes_per_m), 1.0));
    m_last[along] = static_cast<double>(m_cubes.count[axis] - 1);
    blocks.count[axis] = (m_cubes.count[axis] + block_size - 1) / block_size;
  }
  m_lower_m = box.center() - 0.5 * m_edge_m * (m_last + Vec3::Ones());
  m_steps.assign(m_cubes.size(), 0);
  const auto block_count = static_cast<std::ptrdiff_t>(blocks.size());
#pragma omp parallel for num_threads(threads) schedule(dynamic)
  for (std::ptrdiff_t block = 0; block < block_count; ++block) {
    const auto [i, j, k] = blocks.coordinates(static_cast<std::size_t>(block));
    Filling(surface, *this).fill({i * block_size, j * block_size, k * block_size}, block_size);
  }
}

}  // namespace musclebench

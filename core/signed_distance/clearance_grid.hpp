#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/grid_index.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// A lower bound of the distance from points outside to a closed surface, by one table look-up: a coarse grid holds the
/// distance of each cube's centre, and distance is 1-Lipschitz. The bound is 0 closer than about half a cube. Queries
/// are const and safe from several threads.
class ClearanceGrid {
 public:
  /// Without cubes: every clearance is 0.
  ClearanceGrid() = default;

  /// `surface` is closed and lies in `box`; it need not outlive the grid. A cube is a few times `triangle_size_m`, the
  /// mean size of a triangle in metres, or larger to bound the number of cubes. The same for any number of threads.
  ClearanceGrid(const SignedSurface& surface, const Eigen::AlignedBox3d& box, double triangle_size_m, int threads);

  /// Radius in metres of a sphere about `point` (finite, in the surface's frame) that contains no point inside the
  /// surface; 0 where that is unknown.
  [[nodiscard]] double clearance_m(const Vec3& point) const {
    if (m_steps.empty()) {
      return 0;
    }
    const Vec3 scaled = m_cubes_per_m * (point - m_lower_m);
    const Vec3 corner = scaled.array().floor().max(0).min(m_last.array());
    const double to_centre = (scaled - corner - Vec3::Constant(0.5)).norm();
    const auto index = [&](Eigen::Index axis) { return static_cast<std::size_t>(corner[axis]); };
    return std::max(m_steps[m_cubes.index(index(0), index(1), index(2))] / steps_per_cube - to_centre, 0.0) * m_edge_m;
  }

  /// Prefetches what `clearance_m` reads.
  void prefetch(const Vec3& point) const {
    if (m_steps.empty()) {
      return;
    }
    const Vec3 corner = (m_cubes_per_m * (point - m_lower_m)).array().max(0).min(m_last.array());
    const auto index = [&](Eigen::Index axis) { return static_cast<std::size_t>(corner[axis]); };
    __builtin_prefetch(m_steps.data() + m_cubes.index(index(0), index(1), index(2)));
  }

  [[nodiscard]] std::size_t bytes() const { return m_steps.capacity() * sizeof(m_steps[0]); }

 private:
  class Filling;

  /// Resolution of stored distances; 65,535 steps exceed the distance between any two cubes.
  static constexpr double steps_per_cube = 256;

  Vec3 m_lower_m = Vec3::Zero();
  double m_edge_m = 0;
  double m_cubes_per_m = 0;
  GridIndex m_cubes;
  Vec3 m_last = Vec3::Zero();          ///< index of the last cube along each axis
  std::vector<std::uint16_t> m_steps;  ///< distances, rounded down, x fastest; 0 where the centre is inside
};

}  // namespace musclebench

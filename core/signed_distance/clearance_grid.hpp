#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/grid_index.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// How far points outside a closed surface are at least from it, told by one look into memory: in a coarse grid the
/// distance of the centre of each cube is known, and distance is 1-Lipschitz. Of points closer than about half a cube
/// it knows nothing. Queries are const and safe from several threads.
class ClearanceGrid {
 public:
  /// Knows nothing.
  ClearanceGrid() = default;

  /// `surface` is closed and lies in `box`; it need not outlive the grid. Its cubes are as large as some triangles of
  /// mean size `triangle_size_m`, larger where these would be too many. The same for any number of threads.
  ClearanceGrid(const SignedSurface& surface, const Eigen::AlignedBox3d& box, double triangle_size_m, int threads);

  /// The radius of a ball about `point` (finite, in the surface's frame) that holds nothing inside the surface, in
  /// metres; 0 where nothing is known.
  [[nodiscard]] double clearance_m(const Vec3& point) const {
    if (m_steps.empty()) {
      return 0;
    }
    const Vec3 place = m_cubes_per_m * (point - m_lower_m);
    const Vec3 corner = place.array().floor().max(0).min(m_last.array());
    const double away = (place - corner - Vec3::Constant(0.5)).norm();
    const auto index = [&](Eigen::Index axis) { return static_cast<std::size_t>(corner[axis]); };
    return std::max(m_steps[m_cubes.index(index(0), index(1), index(2))] / steps_a_cube - away, 0.0) * m_edge_m;
  }

  /// What `clearance_m` will need begins to come from memory.
  void fetch(const Vec3& point) const {
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

  /// Those that a number holds reach farther than any two cubes are apart.
  static constexpr double steps_a_cube = 256;

  Vec3 m_lower_m = Vec3::Zero();
  double m_edge_m = 0;
  double m_cubes_per_m = 0;
  GridIndex m_cubes;
  Vec3 m_last = Vec3::Zero();          ///< cube along each axis
  std::vector<std::uint16_t> m_steps;  ///< distances, rounded down, x changing fastest; 0 where a centre is inside
};

}  // namespace musclebench

#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Winding numbers of a closed surface about points in a box, from what a ray along an axis passes through: without a
/// tree over the surface, and with few of its triangles where a short way leads out of it.
class RayWinding {
 public:
  /// The surface is closed (`is_closed`) and outlives this. The axis of the rays is the one along which the box of
  /// `points` has the fewest triangles before it.
  RayWinding(const TriangleMesh& mesh, const Eigen::AlignedBox3d& points);

  /// Of a point in the box; nothing where rounding could decide, as on the surface. On a face that is parallel to the
  /// ray a point counts to either side.
  [[nodiscard]] std::optional<int> at(const Vec3& point) const;

 private:
  /// How the axes of a ray's frame follow from x, y and z: rays run along the last.
  struct Frame {
    int u = 0, v = 1, w = 2;
    double sign = 1;  ///< of the direction along w
  };

  [[nodiscard]] static Frame frame_of(int direction);
  [[nodiscard]] std::size_t bin_along(double value, double lower, double per_bin) const;

  const TriangleMesh& m_mesh;
  Frame m_frame;
  double m_uncertain_m = 0;
  // Triangles by bins of (u, v) over the box of points.
  std::size_t m_bins = 1;  ///< along each axis
  Vec3 m_lower, m_per_bin;
  std::vector<std::uint32_t> m_first;  ///< by bin, into m_triangles; one more than bins
  std::vector<int> m_triangles;
};

}  // namespace musclebench

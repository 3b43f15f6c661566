#pragma once

#include <vector>

#include "core/base/random_numbers.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A point of a surface and its triangle.
struct SurfaceSample {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< of the triangle, unit, by its winding
  int triangle = -1;
};

/// Draws points uniformly distributed over a surface's area.
class SurfaceSampler {
 public:
  /// `mesh` outlives the sampler and has an area; triangles without area are never drawn.
  explicit SurfaceSampler(const TriangleMesh& mesh);

  [[nodiscard]] SurfaceSample draw(RandomNumbers& random) const;

 private:
  const TriangleMesh& m_mesh;
  std::vector<double> m_area_until;  ///< cumulative area up to and including a triangle
};

/// The point of the triangle a b c for two numbers in [0, 1): uniformly distributed if they are.
inline Vec3 point_of_triangle(const Vec3& a, const Vec3& b, const Vec3& c, double v, double w) {
  const bool beyond = v + w > 1;
  return a + (beyond ? 1 - v : v) * (b - a) + (beyond ? 1 - w : w) * (c - a);
}

}  // namespace musclebench

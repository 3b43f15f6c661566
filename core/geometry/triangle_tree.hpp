#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "core/geometry/triangle_distance.hpp"
#include "core/geometry/triangle_mesh.hpp"

namespace musclebench {

struct ClosestPoint {
  Vec3 point = Vec3::Zero();
  double distance_m = 0;
  int triangle = -1;
  Feature feature = Feature::face;
};

/// A bounding-box tree over the triangles of a mesh, for closest points and winding numbers. Keeps a copy of the triangles'
/// corners; the mesh need not outlive it. Queries are const and safe from several threads.
class TriangleTree {
 public:
  explicit TriangleTree(const TriangleMesh& mesh);

  /// The closest point within `max_distance_m`; nothing when the surface is farther away. Of several triangles at the same
  /// distance the one with the smallest index.
  [[nodiscard]] std::optional<ClosestPoint> closest_point(
      const Vec3& point, double max_distance_m = std::numeric_limits<double>::infinity()) const;

  /// Generalised winding number (Jacobson et al. 2013), far clusters by their dipole (Barill et al. 2018), refined until the
  /// rounding of the result to inside (> 0.5) or outside is safe. About 1 inside an outward closed surface, 0 outside.
  [[nodiscard]] double winding_number(const Vec3& point) const;

  [[nodiscard]] std::size_t bytes() const;
};

}  // namespace musclebench

#pragma once

#include <cstddef>

#include "core/geometry/signed_surface.hpp"

namespace musclebench {

/// How deep a point is inside a bone, and the way out.
struct Penetration {
  double depth_m = 0;
  Vec3 normal = Vec3::Zero();  ///< unit, out of the bone, rest frame
};

/// The exact surface of one bone in rest pose, held about the middle of its box, so that a bone far from the origin
/// loses no digits.
class CentredSurface {
 public:
  /// Copies what it needs. The surface has triangles.
  explicit CentredSurface(const RepairedMesh& surface);

  /// Whether `rest_point`, a point in the bone's rest frame, is inside, and then how deep. A point that is not finite
  /// is outside.
  [[nodiscard]] bool penetrates(const Vec3& rest_point, Penetration& found) const;

  /// Signed distance of `rest_point`, a finite point in the rest frame, in metres; negative inside.
  [[nodiscard]] double signed_distance_m(const Vec3& rest_point) const {
    return m_surface.locate(rest_point - m_centre_m).signed_distance_m();
  }

  /// Whether the directed edges of all triangles cancel.
  [[nodiscard]] bool closed() const { return m_surface.closed(); }

  [[nodiscard]] std::size_t bytes() const { return sizeof(CentredSurface) + m_surface.bytes(); }

 private:
  CentredSurface(const RepairedMesh& surface, const Eigen::AlignedBox3d& box);

  Vec3 m_centre_m;
  Vec3 m_half_extents_m;
  SignedSurface m_surface;
};

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/mesh/retinaculum.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// How far a tendon is out of one of its rings.
struct RingEscape {
  int ring = -1;          ///< index of the worst; -1: all tendons are in their rings
  double outside_m = 0;   ///< of its farthest point in the ring's plane, beyond the radius
  double share = 0;       ///< of that radius
  bool has_left = false;  ///< nothing of the tendon that the ring knows crosses its plane any more
};

/// Looks where tendons cross the planes of their rings: at their faces, and not at their nodes as the effect does.
class RingMeter {
 public:
  /// `mesh`: of all muscles; its triangles have the nodes that `positions` are of.
  RingMeter(std::span<const Retinaculum> rings, const TriangleMesh& mesh);

  [[nodiscard]] bool has_rings() const { return !m_tendons.empty(); }
  /// Of all rings the largest share. `poses`: by bone, from the rest frame to the world frame. A tendon that does not
  /// cross the plane at all has left the ring: as far as its nearest node is from the centre.
  [[nodiscard]] RingEscape measure(std::span<const Vec3> positions, std::span<const RigidMotion> poses) const;

 private:
  struct Tendon {
    Retinaculum ring;
    std::vector<Triangle> triangles;  ///< whose nodes all are the ring's
  };
  [[nodiscard]] static RingEscape escape(const Tendon& tendon, std::span<const Vec3> positions,
                                         const RigidMotion& pose);

  std::vector<Tendon> m_tendons;
};

}  // namespace musclebench

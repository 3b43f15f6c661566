#include "core/measure/ring_meter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace musclebench {

RingMeter::RingMeter(std::span<const Retinaculum> rings, const TriangleMesh& mesh) {
  for (const Retinaculum& ring : rings) {
    Tendon& tendon = m_tendons.emplace_back(Tendon{ring, {}});
    std::ranges::copy_if(mesh.triangles, std::back_inserter(tendon.triangles), [&](const Triangle& triangle) {
      return std::ranges::all_of(triangle, [&](int node) { return std::ranges::binary_search(ring.nodes, node); });
    });
  }
}

RingEscape RingMeter::measure(std::span<const Vec3> positions, std::span<const RigidMotion> poses) const {
  RingEscape worst;
  for (std::size_t i = 0; i < m_tendons.size(); ++i) {
    const RingEscape found = escape(m_tendons[i], positions, poses[static_cast<std::size_t>(m_tendons[i].ring.bone)]);
    if (!(found.share > worst.share)) continue;
    worst = found;
    worst.ring = static_cast<int>(i);
  }
  return worst;
}

RingEscape RingMeter::escape(const Tendon& tendon, std::span<const Vec3> positions, const RigidMotion& pose) {
  const Retinaculum& ring = tendon.ring;
  const auto from_centre_m = [&](int node) -> Vec3 {
    return pose.apply_inverse(positions[static_cast<std::size_t>(node)]) - ring.centre_m;
  };
  double farthest_m = -1;
  for (const Triangle& triangle : tendon.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 a = from_centre_m(triangle[k]);
      const Vec3 b = from_centre_m(triangle[(k + 1) % 3]);
      const double height_a_m = a.dot(ring.axis);
      const double height_b_m = b.dot(ring.axis);
      if ((height_a_m < 0) == (height_b_m < 0)) continue;
      const Vec3 crossing = a + height_a_m / (height_a_m - height_b_m) * (b - a);
      farthest_m = std::max(farthest_m, crossing.norm());
    }
  }
  const auto told = [&](double outside_m, bool has_left) {
    return RingEscape{.outside_m = outside_m, .share = outside_m / ring.radius_m, .has_left = has_left};
  };
  if (farthest_m >= 0) return told(std::max(0.0, farthest_m - ring.radius_m), false);
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const int node : ring.nodes) nearest_m = std::min(nearest_m, from_centre_m(node).norm());
  return told(nearest_m, true);
}

}  // namespace musclebench

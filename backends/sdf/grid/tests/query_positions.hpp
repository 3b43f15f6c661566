#pragma once

#include <cstddef>
#include <limits>
#include <numeric>
#include <vector>

#include "backends/sdf/grid/grid_shape.hpp"
#include "core/base/random_numbers.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

inline RigidMotion oblique_pose() { return RigidMotion::about_axis(Vec3(1, 2, 2) / 3, {0.1, 0.2, 0.3}, 2.5); }

/// World positions in and about a field's domain, and NaN.
inline std::vector<Vec3> positions_about(const GridShape& shape, const RigidMotion& pose, int count) {
  RandomNumbers random(9);
  std::vector<Vec3> positions;
  for (int n = 0; n < count; ++n) {
    const double x = 1.2 * random.share() - 0.1, y = 1.2 * random.share() - 0.1, z = 1.2 * random.share() - 0.1;
    positions.push_back(pose.apply(shape.lower_m + Vec3(x, y, z).cwiseProduct(shape.upper_m() - shape.lower_m)));
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Vec3& odd : {Vec3(nan, 0, 0), Vec3(0, infinity, 0), Vec3(0, 0, -infinity), Vec3(1e300, 1e300, 1e300)}) {
    positions.insert(positions.begin() + static_cast<std::ptrdiff_t>(positions.size() / 2), odd);
  }
  return positions;
}

inline std::vector<int> all_of(const std::vector<Vec3>& positions) {
  std::vector<int> nodes(positions.size());
  std::iota(nodes.begin(), nodes.end(), 0);
  return nodes;
}

}  // namespace musclebench

#pragma once

#include <random>
#include <vector>

#include "core/base/random_numbers.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// In a cube about the origin, `reach` to each side.
inline std::vector<Vec3> random_points(double reach, int count, unsigned seed = 3) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> coordinate(-reach, reach);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double x = coordinate(generator);
    const double y = coordinate(generator);
    points.emplace_back(x, y, coordinate(generator));
  }
  return points;
}

inline Vec3 random_point(RandomNumbers& random, const Vec3& lower, const Vec3& upper) {
  const double x = random.share();
  const double y = random.share();
  return lower + Vec3(x, y, random.share()).cwiseProduct(upper - lower);
}

}  // namespace musclebench

#include "core/distance/solid_angle_sum.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "core/distance/triangle_distance.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

TEST(SolidAngleSum, IsTheSumOfTheAngles) {
  // Windings of -3 to 3 and, with triangles left out, of all fractions between; points close to faces and far away.
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const TriangleMesh sphere = make_sphere(1, 2);
  double largest_angle = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Vec3 direction = Vec3(uniform(generator), uniform(generator), uniform(generator)).normalized();
    const Vec3 point = (trial % 3 == 0 ? 0.98 : 1.5 * std::abs(uniform(generator))) * direction;
    SolidAngleSum together(point);
    double one_by_one = 0;
    for (int layer = 0; layer < 1 + trial % 3; ++layer) {
      for (const Triangle& t : sphere.triangles) {
        if (trial % 4 == 0 && uniform(generator) < 0.3) continue;
        const Vec3& a = sphere.vertices[static_cast<std::size_t>(t[0])];
        const Vec3& b = sphere.vertices[static_cast<std::size_t>(t[trial % 2 == 0 ? 1 : 2])];
        const Vec3& c = sphere.vertices[static_cast<std::size_t>(t[trial % 2 == 0 ? 2 : 1])];
        together.add(a, b, c);
        one_by_one += solid_angle(point, a, b, c);
      }
    }
    EXPECT_NEAR(together.steradians(), one_by_one, 1e-10) << trial;
    largest_angle = std::max(largest_angle, std::abs(one_by_one));
  }
  EXPECT_GT(largest_angle, 11 * std::numbers::pi);
}

TEST(SolidAngleSum, PassesTheHalfTurnByItsBoundaryOnceForAndBack) {
  SolidAngleSum angles(Vec3::Zero());
  const auto octant = [&](bool is_back) {
    const Vec3 b = Vec3::UnitY(), c = Vec3::UnitZ();
    angles.add(Vec3::UnitX(), is_back ? c : b, is_back ? b : c);
  };
  for (int i = 1; i <= 20; ++i) {
    octant(false);
    EXPECT_NEAR(angles.steradians(), i * std::numbers::pi / 2, 1e-13);
  }
  for (int i = 19; i >= -20; --i) {
    octant(true);
    EXPECT_NEAR(angles.steradians(), i * std::numbers::pi / 2, 1e-13);
  }
}

}  // namespace
}  // namespace musclebench

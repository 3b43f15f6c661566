#include "bench/cases/divergence.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

TEST(Divergence, ANodeFarFromWhereItStartedIsLost) {
  Scene scene;
  scene.add_muscle("muscle", make_box({1, 1, 1}, 1));
  const double diagonal_m = 2 * std::sqrt(3.0);
  const Divergence divergence(scene);
  std::vector<Vec3> positions = scene.muscle_mesh.vertices;
  EXPECT_EQ(divergence.describe(1, positions), "");
  positions[3].x() += 9.9 * diagonal_m;
  EXPECT_EQ(divergence.describe(1, positions), "");
  positions[3].x() += 0.2 * diagonal_m;
  EXPECT_EQ(divergence.describe(7, positions), "frame 7: node 3 left the scene by more than 34.6 m");
  positions[3].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(divergence.describe(7, positions), "");
}

}  // namespace
}  // namespace musclebench

#include "backends/sdf/build/octree_builder.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

TEST(OctreeBuilder, GivesTheSameTreeAtAnyScale) {
  const RepairedMesh small{make_sphere(0.125, 3), true, {}};
  RepairedMesh large = small;
  for (Vec3& vertex : large.mesh.vertices) {
    vertex *= 1024;
  }
  const OctreeField a = build_octree(SignedSurface(small), small.mesh, {.max_error_m = 1e-3}, "a", 1);
  const OctreeField b = build_octree(SignedSurface(large), large.mesh, {.max_error_m = 1.024}, "b", 1);
  EXPECT_EQ(a.entries(), b.entries());
  EXPECT_DOUBLE_EQ(1024 * a.quality().p99_m, b.quality().p99_m);
}

TEST(OctreeBuilder, TellsItsProgress) {
  const RepairedMesh ball{make_sphere(0.1, 3), true, {}};
  double last = 0;
  int calls = 0;
  (void)build_octree(SignedSurface(ball), ball.mesh, {.max_error_m = 2e-5}, "ball", 1, [&](double share) {
    EXPECT_GE(share, last);
    EXPECT_LE(share, 1);
    last = share;
    ++calls;
  });
  EXPECT_GT(calls, 2);
  EXPECT_EQ(last, 1);
}

std::string refusal(const OctreeSettings& settings) {
  const RepairedMesh ball{make_sphere(0.1, 3), true, {}};
  try {
    (void)build_octree(SignedSurface(ball), ball.mesh, settings, "ball", 1);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(OctreeBuilder, RefusesErrorsOutOfAllProportion) {
  for (const double wanted_m : {1e-12, 0.05, std::nan("")}) {
    const std::string words = refusal({.max_error_m = wanted_m});
    EXPECT_NE(words.find("max_error_mm (ball)"), std::string::npos) << words;
    EXPECT_NE(words.find("makes sense"), std::string::npos) << words;
  }
}

TEST(OctreeBuilder, RefusesWhatDoesNotFitIntoMemoryAndSaysWhatDoes) {
  constexpr std::size_t memory = 60'000'000;
  const std::string words = refusal({.max_error_m = 1e-7, .memory_bytes = memory});
  EXPECT_NE(words.find("needs about"), std::string::npos) << words;
  EXPECT_NE(words.find("60 MB are there"), std::string::npos) << words;
  const std::size_t fits = words.find(" fits");
  ASSERT_NE(fits, std::string::npos) << words;
  const double fitting_mm = std::stod(words.substr(words.rfind(' ', fits - 1)));
  EXPECT_GT(fitting_mm, 1e-4);
  EXPECT_EQ(refusal({.max_error_m = 1e-3 * fitting_mm, .memory_bytes = memory}), "");
}

TEST(OctreeBuilder, LearnsHowItsMemoryGrows) {
  // Once the edges of a box are a hundredth of the points, a smaller error costs next to nothing.
  const RepairedMesh box{make_box({0.03, 0.03, 0.03}, 2), true, {}};
  const OctreeField field =
      build_octree(SignedSurface(box), box.mesh, {.max_error_m = 2e-6, .memory_bytes = 300'000'000}, "box", 2);
  EXPECT_LE(field.quality().p99_m, 2e-6);
}

}  // namespace
}  // namespace musclebench

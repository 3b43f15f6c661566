#include "core/fibres/fibre_segments.hpp"

#include <gtest/gtest.h>

#include "core/fibres/fibre_alignment.hpp"

namespace musclebench {
namespace {

/// A fibre ends at its ends: the first one's line runs through the point, but far from it.
TEST(Fibres, TheNearestIsASegmentNotItsLine) {
  const std::vector<FibreSegment> fibres = {{Vec3(5, 0, 0), Vec3(6, 0, 0)}, {Vec3(0, 1, 0), Vec3(0, 3, 0)}};
  EXPECT_EQ(alignment_with_nearest_fibre(fibres, Vec3::Zero(), Vec3::UnitY()), 1);
  EXPECT_EQ(alignment_with_nearest_fibre(fibres, Vec3::Zero(), Vec3::UnitX()), 0);
  EXPECT_EQ(alignment_with_nearest_fibre(fibres, Vec3(5.5, 0.1, 0), Vec3::UnitX()), 1);
}

/// On a flat strip the function between its ends is linear, whatever its triangles, as long as none is obtuse: all
/// fibres run straight along, but for the right angles at the ends, whose cotangents are kept from 0.
TEST(Fibres, RunStraightAlongAStrip) {
  TriangleMesh strip;
  constexpr int columns = 6;
  for (int i = 0; i < columns; ++i) {
    const double bent = -0.3 * (i % 2);
    strip.vertices.insert(strip.vertices.end(), {Vec3(i, 0, 0), Vec3(i + (i % (columns - 1) == 0 ? 0 : bent), 1, 0)});
  }
  for (int i = 0; i + 1 < columns; ++i) {
    strip.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 3});
    strip.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 1});
  }
  const auto fibres = fibres_between(strip, {0, 1}, {2 * columns - 2, 2 * columns - 1}, 1000);
  ASSERT_EQ(fibres.size(), strip.triangles.size());
  for (const FibreSegment& fibre : fibres) {
    EXPECT_GT((fibre.end - fibre.start).normalized().x(), 0.9995);
  }
}

}  // namespace
}  // namespace musclebench

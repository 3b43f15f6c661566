#include "core/contact/surface_queries.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

/// A bone between z = 0 and z = 2, with the surface of a part that overlaps it at `inner_m`.
class Slab final : public SurfaceQueries {
 public:
  explicit Slab(double inner_m) : m_inner_m(inner_m) {}

  [[nodiscard]] SurfaceAnswer locate(const Vec3& point, int /*near*/) const override {
    const double z = point.z();
    const double outer_m = std::min(z, 2 - z);
    const double distance_m = outer_m > 0 ? -std::min(outer_m, std::abs(z - m_inner_m)) : -outer_m;
    return {distance_m, Vec3::UnitZ(), point, 0};
  }
  [[nodiscard]] Clearance clearance(const Vec3& /*point*/, int /*near*/) const override { return {}; }
  [[nodiscard]] std::size_t bytes() const override { return 0; }

 private:
  double m_inner_m;
};

TEST(SurfaceQueries, StepsOfTheFreeDistanceFindTheWayOut) {
  const Slab slab(-1);
  std::vector<PathCrossing> scratch;
  const auto way_m = [&](const Vec3& direction, double length_m) {
    return slab.way_out_m({0, 0, 0.5}, direction.normalized(), length_m, -1, scratch);
  };
  EXPECT_NEAR(way_m(Vec3::UnitZ(), 4).value_or(-1), 1.5, 1e-5);
  EXPECT_NEAR(way_m(-Vec3::UnitZ(), 4).value_or(-1), 0.5, 1e-5);
  EXPECT_NEAR(way_m({0, 1, 1}, 4).value_or(-1), 1.5 * std::sqrt(2), 1e-4);
  EXPECT_FALSE(way_m(Vec3::UnitZ(), 1)) << "it ends inside";
  EXPECT_FALSE(way_m(Vec3::UnitX(), 4)) << "along the surface";
}

TEST(SurfaceQueries, TheSurfaceOfAPartThatOverlapsIsNoWayOut) {
  const Slab slab(1);
  std::vector<PathCrossing> scratch;
  EXPECT_FALSE(slab.way_out_m({0, 0, 0.5}, Vec3::UnitZ(), 4, -1, scratch));
}

}  // namespace
}  // namespace musclebench

#include "backends/sdf/octree/octree_field.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "backends/sdf/build/octree_builder.hpp"
#include "backends/sdf/build/reference_samples.hpp"
#include "core/base/random_numbers.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/tests/random_points.hpp"

namespace musclebench {
namespace {

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// A bone with a field to 0.2 mm: sharp edges, flat faces, and a box of 0.2 x 0.1 x 0.1 m.
class OctreeOfBox : public testing::Test {
 protected:
  static constexpr double wanted_m = 2e-4;
  static OctreeField build(int threads) {
    return build_octree(surface(), bone().mesh, {.max_error_m = wanted_m}, "box", threads);
  }
  static const RepairedMesh& bone() {
    static const RepairedMesh mesh{make_box({0.1, 0.05, 0.05}, 2), true, {}};
    return mesh;
  }
  static const SignedSurface& surface() {
    static const SignedSurface made(bone());
    return made;
  }
  static const OctreeField& field() {
    static const OctreeField built = build(2);
    return built;
  }
  static std::vector<Vec3> points(int count, std::uint64_t seed) {
    RandomNumbers random(seed);
    std::vector<Vec3> result;
    for (int i = 0; i < count; ++i) {
      result.push_back(random_point(random, field().shape().lower_m, field().shape().upper_m()));
    }
    return result;
  }
};

TEST_F(OctreeOfBox, KeepsTheWantedErrorNearTheSurface) {
  const OctreeQuality& quality = field().quality();
  std::vector<double> errors;
  for (const ReferenceSample& sample : reference_samples(surface(), bone().mesh, quality.near_m, 5000, 99, 1)) {
    if (const auto value = field().value(sample.point)) {
      errors.push_back(std::abs(*value - sample.distance_m));
    }
  }
  ASSERT_GT(errors.size(), 4000U);
  EXPECT_LE(quantile(errors, 0.99), wanted_m);
  EXPECT_LE(quality.p99_m, wanted_m);
  EXPECT_GT(quality.p99_m, 0.1 * wanted_m) << "far finer than wanted";
  EXPECT_NEAR(quantile(errors, 0.99), quality.p99_m, 0.3 * quality.p99_m);
  EXPECT_LT(quantile(errors, 1), 2 * quality.largest_m);
}

/// Not that of a tree or of polynomials that were given up for better ones.
TEST_F(OctreeOfBox, ReportsTheErrorOfTheFieldThatWasBuilt) {
  const OctreeQuality& quality = field().quality();
  const auto count = static_cast<std::size_t>(quality.samples);
  double mean_m = 0;
  double largest_m = 0;
  for (const ReferenceSample& sample : reference_samples(surface(), bone().mesh, quality.near_m, count, 1, 1)) {
    const double error_m = std::abs(field().value(sample.point).value() - sample.distance_m);
    mean_m += error_m / static_cast<double>(count);
    largest_m = std::max(largest_m, error_m);
  }
  EXPECT_NEAR(quality.mean_m, mean_m, 1e-9 * mean_m);
  EXPECT_NEAR(quality.largest_m, largest_m, 1e-9 * largest_m);
}

TEST_F(OctreeOfBox, IsFineAtEdgesAndCoarseElsewhere) {
  EXPECT_LE(field().step_m(), field().shape().root_edge_m / 4);
  const double uniform = field().shape().root_count() * std::pow(field().shape().root_edge_m / field().step_m(), 3);
  EXPECT_LT(static_cast<double>(field().leaf_count()), 0.15 * uniform);
}

/// What 99 of 100 points near the surface, on planes that may be faces of the finest leaves, jump by at most. What
/// jumps less than `least_m` does not count: there the plane goes through a leaf.
double p99_jump_m(const OctreeField& field, const SignedSurface& surface, double least_m = 0) {
  const Vec3 lower = field.shape().lower_m;
  const double step_m = field.step_m();
  RandomNumbers random(8);
  std::vector<double> jumps;
  while (jumps.size() < 10000) {
    Vec3 point = random_point(random, lower, field.shape().upper_m());
    const auto axis = static_cast<Eigen::Index>(random.below(3));
    point[axis] = lower[axis] + std::round((point[axis] - lower[axis]) / step_m) * step_m;
    const Vec3 aside = 1e-9 * Vec3::Unit(axis);
    if (!surface.distance(point, field.quality().near_m) || !field.value(point - aside) ||
        !field.value(point + aside)) {
      continue;
    }
    const double jump = std::abs(*field.value(point + aside) - *field.value(point - aside));
    if (jump >= least_m) {
      jumps.push_back(jump);
    }
  }
  return quantile(jumps, 0.99);
}

TEST_F(OctreeOfBox, JumpsByLessThanTheWantedErrorFromCellToCell) {
  EXPECT_LT(p99_jump_m(field(), surface()), wanted_m);
}

TEST(OctreeField, JumpsByLessThanTheWantedErrorWhereTheSurfaceIsRough) {
  RandomNumbers random(3);
  RepairedMesh ball{make_sphere(0.05, 4), true, {}};
  for (Vec3& vertex : ball.mesh.vertices) {
    vertex *= 1 + 0.1 * random.share();
  }
  const SignedSurface surface(ball);
  constexpr double wanted_m = 4e-4;
  const OctreeField field = build_octree(surface, ball.mesh, {.max_error_m = wanted_m}, "rough ball", 2);
  constexpr double rounding_m = 1e-8;
  EXPECT_LT(p99_jump_m(field, surface, rounding_m), wanted_m);
}

TEST_F(OctreeOfBox, FindsDeepPointsInside) {
  int inside = 0;
  for (const Vec3& point : points(20000, 4)) {
    const double exact = surface().locate(point).signed_distance_m();
    const double value = *field().value(point);
    if (value < 0) {
      EXPECT_LT(exact, field().quality().largest_m * 2);
    } else {
      EXPECT_GT(exact, -field().quality().largest_m * 2);
    }
    if (exact < -field().quality().near_m && value < 0) {
      EXPECT_NEAR(value, exact, 2e-3 - 0.3 * exact) << "far inside the error may grow";
      ++inside;
    }
  }
  EXPECT_GT(inside, 1000);
}

TEST(OctreeField, IsALowerBoundWhereItHasNoPolynomial) {
  const RepairedMesh ball{make_sphere(0.1, 3), true, {}};
  const SignedSurface surface(ball);
  const OctreeField field = build_octree(surface, ball.mesh, {.max_error_m = 1e-3}, "ball", 1);
  RandomNumbers random(5);
  int outside = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 point = random_point(random, field.shape().lower_m, field.shape().upper_m());
    const double exact = surface.locate(point).signed_distance_m();
    const OctreeField::Sample sample = *field.sample(point);
    // A distance to a point has a gradient of unit length; a polynomial almost never.
    if (std::abs(sample.gradient.norm() - 1) < 1e-12) {
      EXPECT_LE(sample.value_m, exact);
      EXPECT_GE(exact, field.quality().near_m);
      ++outside;
    }
  }
  EXPECT_GT(outside, 1000);
}

TEST_F(OctreeOfBox, ErrorsStayWithinTheirProvenBounds) {
  const OctreeQuality& quality = field().quality();
  for (const Vec3& point : points(20000, 6)) {
    const double exact = surface().locate(point).signed_distance_m();
    const double value = *field().value(point);
    if ((exact < 0) != (value < 0)) {
      EXPECT_LE(std::abs(exact), quality.bound_m);
    }
    EXPECT_TRUE(value >= 0 || exact <= quality.sign_error_distance_m) << exact;
  }
}

TEST_F(OctreeOfBox, IsNotNegativeWithinTheClearance) {
  RandomNumbers random(12);
  int clear = 0;
  const Vec3 margin = Vec3::Constant(0.03);
  for (int i = 0; i < 5000; ++i) {
    const Vec3 point = random_point(random, field().shape().lower_m - margin, field().shape().upper_m() + margin);
    const double radius = field().clearance_m(point);
    EXPECT_LE(radius, std::max(0.0, surface().locate(point).signed_distance_m()) + 2 * field().quality().largest_m);
    clear += radius > 0 ? 1 : 0;
    for (int j = 0; radius > 0 && j < 10; ++j) {
      const Vec3 direction = random_point(random, Vec3::Constant(-1), Vec3::Constant(1)).normalized();
      EXPECT_GE(field().value(point + radius * direction).value_or(0), 0);
    }
  }
  EXPECT_GT(clear, 500);
}

/// Balls that are small in coarse cells are left in every step.
TEST_F(OctreeOfBox, IsClearNotMuchFartherFromTheSurfaceThanItIsNegative) {
  const OctreeQuality& quality = field().quality();
  double free_m = 0;
  double clear_m = 0;
  for (const Vec3& point : points(5000, 13)) {
    const double exact = surface().locate(point).signed_distance_m();
    const double least_m = quality.sign_error_distance_m + quality.excess_m;
    if (exact > 2 * least_m) {
      free_m += exact - least_m;
      clear_m += field().clearance_m(point);
    }
  }
  EXPECT_GT(free_m, 0);
  EXPECT_GT(clear_m, 0.6 * free_m);
}

/// So near the surface only the leaf itself tells how far the field is positive.
TEST_F(OctreeOfBox, IsClearToTheSurfaceOrTheFacesOfItsLeaf) {
  int near = 0;
  int clear = 0;
  for (const Vec3& point : points(20000, 14)) {
    const double value = field().value(point).value();
    if (value > 0 && value < field().quality().sign_error_distance_m) {
      ++near;
      clear += field().clearance_m(point) > 0.1 * value ? 1 : 0;
    }
  }
  EXPECT_GT(near, 500);
  EXPECT_GT(clear, 0.8 * near);
}

TEST_F(OctreeOfBox, IsTheSameForAnyNumberOfThreads) {
  const OctreeField one = build(1);
  EXPECT_EQ(one.entries(), field().entries());
  EXPECT_EQ(one.coefficients(), field().coefficients());
  EXPECT_EQ(one.quality().bound_m, field().quality().bound_m);
  EXPECT_EQ(one.quality().sign_error_distance_m, field().quality().sign_error_distance_m);
  EXPECT_EQ(one.quality().excess_m, field().quality().excess_m);
  EXPECT_EQ(one.quality().mean_m, field().quality().mean_m);
}

TEST_F(OctreeOfBox, HasNothingToSayOutsideItsDomain) {
  const Vec3 far = field().shape().upper_m() + Vec3::Constant(1);
  EXPECT_FALSE(field().value(far));
  EXPECT_FALSE(field().sample(far));
  EXPECT_FALSE(field().sample(Vec3::Constant(std::nan(""))));
  EXPECT_TRUE(field().value(field().shape().upper_m()));
  EXPECT_TRUE(field().value(field().shape().lower_m));
}

}  // namespace
}  // namespace musclebench

#include "backends/sdf/octree_field.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "backends/sdf/exact_places.hpp"
#include "backends/sdf/octree_builder.hpp"
#include "backends/sdf/octree_fit.hpp"
#include "backends/sdf/octree_reach.hpp"
#include "core/base/input_error.hpp"
#include "core/base/random_numbers.hpp"
#include "core/geometry/shapes.hpp"

namespace musclebench {
namespace {

Vec3 random_point(RandomNumbers& random, const Vec3& lower, const Vec3& upper) {
  const double x = random.share();
  const double y = random.share();
  return lower + Vec3(x, y, random.share()).cwiseProduct(upper - lower);
}

double monomial(std::size_t term, const Vec3& at) {
  const auto& [x, y, z] = polynomial_powers[term];
  return std::pow(at[0], x) * std::pow(at[1], y) * std::pow(at[2], z);
}

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

TEST(OctreePolynomial, HasTheValueAndTheSlopesOfItsTerms) {
  RandomNumbers random(3);
  std::array<float, cubic_terms> c{};
  for (float& value : c) {
    value = static_cast<float>(random.share() - 0.5);
  }
  for (int i = 0; i < 50; ++i) {
    const Vec3 at = random_point(random, Vec3::Constant(-1), Vec3::Constant(1));
    for (const std::size_t terms : {quadratic_terms, cubic_terms}) {
      const auto expected = [&](const Vec3& place) {
        double sum = 0;
        for (std::size_t term = 0; term < terms; ++term) {
          sum += static_cast<double>(c[term]) * monomial(term, place);
        }
        return sum;
      };
      Vec3 gradient;
      const double value = terms == cubic_terms ? evaluate_polynomial<true>(c.data(), at, gradient)
                                                : evaluate_polynomial<false>(c.data(), at, gradient);
      EXPECT_NEAR(value, expected(at), 1e-14);
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const Vec3 step = 1e-4 * Vec3::Unit(axis);
        EXPECT_NEAR(gradient[axis], (expected(at + step) - expected(at - step)) / 2e-4, 1e-7);
      }
    }
  }
}

template <std::size_t terms>
void find_polynomial() {
  constexpr double half_edge_m = 0.004;
  RandomNumbers random(terms);
  PolynomialFit wanted;
  for (std::size_t term = 0; term < terms; ++term) {
    wanted.coefficients[term] = static_cast<float>(random.share() - 0.5);
  }
  CellSamples samples;
  for (std::size_t s = 0; s < cell_samples; ++s) {
    Vec3 gradient;
    const double value = evaluate_polynomial<true>(wanted.coefficients.data(), sample_place(s), gradient);
    gradient /= half_edge_m;
    samples[s] = {
        value, {static_cast<float>(gradient[0]), static_cast<float>(gradient[1]), static_cast<float>(gradient[2])}, 0};
  }
  const PolynomialFitter<terms> fitter;
  PolynomialFit found = fitter.fit(samples, half_edge_m);
  for (std::size_t term = 0; term < cubic_terms; ++term) {
    EXPECT_NEAR(found.coefficients[term], wanted.coefficients[term], 1e-6) << term;
  }
  const CellErrors errors_m = fitter.measure(samples, half_edge_m, found);
  EXPECT_LT(*std::max_element(errors_m.begin(), errors_m.end()), 2e-6);
  EXPECT_NEAR(found.excess_m, 0, 5e-6);
  samples[30].value_m += 1;
  EXPECT_NEAR(fitter.measure(samples, half_edge_m, found)[30], 1, 2e-6) << "an octant's middle counts";
  EXPECT_NEAR(found.excess_m, 0, 5e-6) << "too low is no excess";
  EXPECT_GT(fitter.fit(samples, half_edge_m).coefficients[0], found.coefficients[0] + 1e-3);
  samples[30].value_m -= 2;
  (void)fitter.measure(samples, half_edge_m, found);
  EXPECT_NEAR(found.excess_m, 1, 5e-6);
  PolynomialFit negative = found;
  negative.coefficients[0] -= 10;
  (void)fitter.measure(samples, half_edge_m, negative);
  EXPECT_EQ(negative.excess_m, 0) << "where it is negative";
  for (std::size_t s = lattice_samples; s < cell_samples; ++s) {
    samples[s].triangle = -1;
  }
  const PolynomialFit by_lattice = fitter.fit(samples, half_edge_m);
  for (std::size_t term = 0; term < cubic_terms; ++term) {
    EXPECT_NEAR(by_lattice.coefficients[term], wanted.coefficients[term], 1e-6) << "of what is not known, " << term;
  }
}

TEST(PolynomialFitter, FindsThePolynomialThatItIsGiven) {
  find_polynomial<quadratic_terms>();
  find_polynomial<cubic_terms>();
}

TEST_F(OctreeOfBox, KeepsTheWantedErrorNearTheSurface) {
  const OctreeQuality& quality = field().quality();
  std::vector<double> errors;
  for (const ExactPlace& place : places_about(surface(), bone().mesh, quality.near_m, 5000, 99, 1)) {
    if (const auto value = field().value(place.point)) {
      errors.push_back(std::abs(*value - place.distance_m));
    }
  }
  ASSERT_GT(errors.size(), 4000U);
  EXPECT_LE(quantile(errors, 0.99), wanted_m);
  EXPECT_LE(quality.p99_m, wanted_m);
  EXPECT_GT(quality.p99_m, 0.1 * wanted_m) << "far finer than asked for";
  EXPECT_NEAR(quantile(errors, 0.99), quality.p99_m, 0.3 * quality.p99_m);
  EXPECT_LT(quantile(errors, 1), 2 * quality.largest_m);
}

/// Not that of a tree or of polynomials that were given up for better ones.
TEST_F(OctreeOfBox, ReportsTheErrorOfTheFieldThatWasBuilt) {
  const OctreeQuality& quality = field().quality();
  const auto count = static_cast<std::size_t>(quality.samples);
  double mean_m = 0;
  double largest_m = 0;
  for (const ExactPlace& place : places_about(surface(), bone().mesh, quality.near_m, count, 1, 1)) {
    const double error_m = std::abs(field().value(place.point).value() - place.distance_m);
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

/// What 99 of 100 places near the surface, on planes that may be faces of the finest leaves, jump by at most. What
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
    EXPECT_TRUE(value >= 0 || exact <= quality.negative_reach_m) << exact;
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
      const Vec3 way = random_point(random, Vec3::Constant(-1), Vec3::Constant(1)).normalized();
      EXPECT_GE(field().value(point + radius * way).value_or(0), 0);
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
    const double least_m = quality.negative_reach_m + quality.excess_m;
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
    if (value > 0 && value < field().quality().negative_reach_m) {
      ++near;
      clear += field().clearance_m(point) > 0.1 * value ? 1 : 0;
    }
  }
  EXPECT_GT(near, 500);
  EXPECT_GT(clear, 0.8 * near);
}

/// A leaf with half an edge of 1 that knows `known` distances.
OctreeCell sampled_cell(const SignedSurface& surface, const Vec3& centre_m, std::size_t known = cell_samples) {
  OctreeCell cell;
  cell.centre_m = centre_m;
  cell.half_edge_m = 1;
  cell.distance_m = surface.locate(centre_m).signed_distance_m();
  cell.leaf = std::make_unique<OctreeCell::Leaf>();
  for (std::size_t s = 0; s < known; ++s) {
    const SignedPoint place = surface.locate(centre_m + sample_place(s));
    cell.leaf->samples[s] = {place.signed_distance_m(), {0, 0, 1}, place.closest.triangle};
  }
  return cell;
}

TEST(OctreeReach, IsWhereThePolynomialIsNegativeOutside) {
  // Everything below z = -0.4 is inside; the polynomial takes everything below z = 0.1 for it.
  const RepairedMesh box{make_box({10, 10, 9.6}, 1), true, {}};
  const SignedSurface surface(box);
  OctreeCell cell = sampled_cell(surface, Vec3(0, 0, 10));
  PolynomialFit& fit = cell.leaf->quadratic;
  fit.coefficients[0] = -0.1F;
  fit.coefficients[3] = 1;
  for (const double least_m : {0.01, 0.1, 0.4}) {
    const double reach_m = negative_reach_m(surface, cell, fit, quadratic_terms, least_m);
    EXPECT_GE(reach_m, 0.5);
    EXPECT_LE(reach_m, 0.5 + least_m);
  }
  EXPECT_EQ(negative_reach_m(surface, cell, fit, quadratic_terms, 0.8), 0.8);
  fit.coefficients[0] = 1.1F;
  EXPECT_EQ(negative_reach_m(surface, cell, fit, quadratic_terms, 0.01), 0.01);
  // Flat and positive in the middle.
  for (const std::size_t falling : {std::size_t{4}, quadratic_terms}) {
    fit = {};
    fit.coefficients[0] = 0.5F;
    fit.coefficients[falling] = -1;
    EXPECT_NEAR(negative_reach_m(surface, cell, fit, cubic_terms, 0.1), 1.4, 0.1);
  }
}

/// Where it is negative deep inside only, nothing is to be proven, whatever triangles the samples name.
TEST(OctreeReach, IsTheLeastWhereThePolynomialIsTheDistance) {
  const RepairedMesh box{make_box({10, 10, 9.6}, 4), true, {}};
  const SignedSurface surface(box);
  for (const double above_m : {-1.4, -0.5, 0.2}) {
    for (const std::size_t known : {lattice_samples, cell_samples}) {
      OctreeCell cell = sampled_cell(surface, Vec3(0.3, 0.2, 9.6 + above_m), known);
      PolynomialFit& fit = cell.leaf->quadratic;
      fit.coefficients[0] = static_cast<float>(above_m);
      fit.coefficients[3] = 1;
      for (const double least_m : {0.02, 0.3}) {
        EXPECT_EQ(negative_reach_m(surface, cell, fit, quadratic_terms, least_m), least_m);
      }
      for (std::size_t s = 0; s < known; ++s) {
        cell.leaf->samples[s].triangle = 0;
      }
      EXPECT_EQ(negative_reach_m(surface, cell, fit, quadratic_terms, 0.02), 0.02);
    }
  }
}

TEST_F(OctreeOfBox, IsTheSameForAnyNumberOfThreads) {
  const OctreeField one = build(1);
  EXPECT_EQ(one.entries(), field().entries());
  EXPECT_EQ(one.coefficients(), field().coefficients());
  EXPECT_EQ(one.quality().bound_m, field().quality().bound_m);
  EXPECT_EQ(one.quality().negative_reach_m, field().quality().negative_reach_m);
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
  // Once the edges of a box are a hundredth of the places, a smaller error costs next to nothing.
  const RepairedMesh box{make_box({0.03, 0.03, 0.03}, 2), true, {}};
  const OctreeField field =
      build_octree(SignedSurface(box), box.mesh, {.max_error_m = 2e-6, .memory_bytes = 300'000'000}, "box", 2);
  EXPECT_LE(field.quality().p99_m, 2e-6);
}

}  // namespace
}  // namespace musclebench

#include "backends/sdf/build/octree_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "backends/sdf/octree/octree_field.hpp"
#include "core/base/random_numbers.hpp"
#include "core/mesh/tests/random_points.hpp"

namespace musclebench {
namespace {

double monomial(std::size_t term, const Vec3& at) {
  const auto& [x, y, z] = polynomial_powers[term];
  return std::pow(at[0], x) * std::pow(at[1], y) * std::pow(at[2], z);
}

TEST(OctreePolynomial, HasTheValueAndTheSlopesOfItsTerms) {
  RandomNumbers random(3);
  std::array<float, cubic_terms> c{};
  for (float& value : c) {
    value = static_cast<float>(random.share() - 0.5);
  }
  for (int i = 0; i < 50; ++i) {
    const Vec3 at = random_point(random, Vec3::Constant(-1), Vec3::Constant(1));
    for (const std::size_t terms : {quadratic_terms, cubic_terms}) {
      const auto expected = [&](const Vec3& point) {
        double sum = 0;
        for (std::size_t term = 0; term < terms; ++term) {
          sum += static_cast<double>(c[term]) * monomial(term, point);
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
  constexpr double fit_half_edge_m = 0.004;
  RandomNumbers random(terms);
  PolynomialFit wanted;
  for (std::size_t term = 0; term < terms; ++term) {
    wanted.coefficients[term] = static_cast<float>(random.share() - 0.5);
  }
  CellSamples samples;
  for (std::size_t s = 0; s < cell_samples; ++s) {
    Vec3 gradient;
    const double value = evaluate_polynomial<true>(wanted.coefficients.data(), sample_position(s), gradient);
    gradient /= fit_half_edge_m;
    samples[s] = {
        value, {static_cast<float>(gradient[0]), static_cast<float>(gradient[1]), static_cast<float>(gradient[2])}, 0};
  }
  const PolynomialFitter<terms> fitter;
  PolynomialFit found = fitter.fit(samples, fit_half_edge_m);
  for (std::size_t term = 0; term < cubic_terms; ++term) {
    EXPECT_NEAR(found.coefficients[term], wanted.coefficients[term], 1e-6) << term;
  }
  const CellErrors errors_m = fitter.measure(samples, fit_half_edge_m, found);
  EXPECT_LT(*std::max_element(errors_m.begin(), errors_m.end()), 2e-6);
  EXPECT_NEAR(found.excess_m, 0, 5e-6);
  samples[30].value_m += 1;
  EXPECT_NEAR(fitter.measure(samples, fit_half_edge_m, found)[30], 1, 2e-6) << "an octant's middle counts";
  EXPECT_NEAR(found.excess_m, 0, 5e-6) << "too low is no excess";
  EXPECT_GT(fitter.fit(samples, fit_half_edge_m).coefficients[0], found.coefficients[0] + 1e-3);
  samples[30].value_m -= 2;
  (void)fitter.measure(samples, fit_half_edge_m, found);
  EXPECT_NEAR(found.excess_m, 1, 5e-6);
  PolynomialFit negative = found;
  negative.coefficients[0] -= 10;
  (void)fitter.measure(samples, fit_half_edge_m, negative);
  EXPECT_EQ(negative.excess_m, 0) << "where it is negative";
  for (std::size_t s = lattice_samples; s < cell_samples; ++s) {
    samples[s].triangle = -1;
  }
  const PolynomialFit by_lattice = fitter.fit(samples, fit_half_edge_m);
  for (std::size_t term = 0; term < cubic_terms; ++term) {
    EXPECT_NEAR(by_lattice.coefficients[term], wanted.coefficients[term], 1e-6) << "of what is not known, " << term;
  }
}

TEST(PolynomialFitter, FindsThePolynomialThatItIsGiven) {
  find_polynomial<quadratic_terms>();
  find_polynomial<cubic_terms>();
}

/// A distance may rise by a metre a metre away from the samples, where a polynomial that is 0 everywhere does not
/// follow.
TEST(OctreePolynomial, TheBoundCoversWhatLiesBetweenSamples) {
  constexpr double fit_half_edge_m = 0.004;
  for (const bool with_octants : {false, true}) {
    CellSamples samples;
    samples.fill({0, {0, 0, 0}, 0});
    if (!with_octants) std::fill(samples.begin() + lattice_samples, samples.end(), DistanceSample{0, {0, 0, 0}, -1});
    PolynomialFit zero;
    (void)PolynomialFitter<cubic_terms>().measure(samples, fit_half_edge_m, zero);
    double farthest_m = 0;
    constexpr int parts = 20;
    for (int i = 0; i < (parts + 1) * (parts + 1) * (parts + 1); ++i) {
      const Vec3 at = Vec3(i % (parts + 1), i / (parts + 1) % (parts + 1), i / (parts + 1) / (parts + 1)) * 2 / parts -
                      Vec3::Ones();
      double nearest = 4;
      for (std::size_t s = 0; s < known_samples(samples); ++s) {
        nearest = std::min(nearest, (sample_position(s) - at).norm());
      }
      farthest_m = std::max(farthest_m, fit_half_edge_m * nearest);
    }
    EXPECT_GE(zero.bound_m, farthest_m * 0.9999) << with_octants;
    EXPECT_LT(zero.bound_m, 1.2 * farthest_m) << with_octants;
  }
}

}  // namespace
}  // namespace musclebench

#include "core/base/portable_math.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace musclebench {
namespace {

double ulp(double value) {
  return std::nextafter(std::abs(value), std::numeric_limits<double>::infinity()) - std::abs(value);
}

/// The largest error against the C library's long double, of 200,000 arguments from `low` to `high`.
template <typename Function, typename Exact>
double largest_error_ulp(double low, double high, const Function& function, const Exact& exact) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> argument(low, high);
  double largest = 0;
  for (int i = 0; i < 200'000; ++i) {
    const double x = argument(random);
    const long double wanted = exact(static_cast<long double>(x));
    const double unit = ulp(std::max(std::abs(static_cast<double>(wanted)), 1e-300));
    largest = std::max(largest, static_cast<double>(std::abs(function(x) - wanted)) / unit);
  }
  return largest;
}

TEST(PortableMath, ExponentialIsRightToTwoUnits) {
  const auto exact = [](long double x) { return std::exp(x); };
  EXPECT_LT(largest_error_ulp(-1, 1, portable::exp, exact), 2);
  EXPECT_LT(largest_error_ulp(-600, 600, portable::exp, exact), 2);
  EXPECT_EQ(portable::exp(0), 1);
  EXPECT_EQ(portable::exp(-1e4), 0);
}

TEST(PortableMath, PowersAreRightToWhatTheirLogarithmAllows) {
  for (const double exponent : {0.5, 1.0, 2.0, 16.0}) {
    const auto power = [&](double x) { return portable::pow(x, exponent); };
    const auto exact = [&](long double x) { return std::pow(x, static_cast<long double>(exponent)); };
    EXPECT_LT(largest_error_ulp(0.5, 1, power, exact), 3 + 4 * exponent * std::log(2)) << exponent;
    EXPECT_LT(largest_error_ulp(1e-3, 0.5, power, exact), 3 + 4 * exponent * std::log(1e3)) << exponent;
    EXPECT_EQ(portable::pow(0, exponent), 0);
    EXPECT_EQ(portable::pow(1, exponent), 1);
  }
  EXPECT_EQ(portable::pow(0, 0), 1);
  EXPECT_EQ(portable::pow(0.3, 0), 1);
}

TEST(PortableMath, SineAndCosineAreRightToTheirLastUnits) {
  for (const double reach : {0.8, 7.0, 1e3, 1e6}) {
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> angle(-reach, reach);
    for (int i = 0; i < 50'000; ++i) {
      const double x = angle(random);
      ASSERT_NEAR(portable::sin(x), std::sin(static_cast<long double>(x)), 2.5e-16) << x;
      ASSERT_NEAR(portable::cos(x), std::cos(static_cast<long double>(x)), 2.5e-16) << x;
    }
  }
  const double far = 1.5e9;
  EXPECT_NEAR(portable::sin(far), std::sin(far), 1e-6);
  EXPECT_EQ(portable::sin(0), 0);
  EXPECT_EQ(portable::cos(0), 1);
}

/// As on every CPU: recorded once. The C library's sum differs between CPUs with and without FMA.
TEST(PortableMath, BitsAreThoseOfEveryCpu) {
  double sum = 0;
  for (int i = 1; i <= 1000; ++i) {
    const double x = 0.001 * i;
    sum = 0.99 * sum + portable::exp(-x) + portable::pow(x, 0.5) + portable::sin(7 * x) + portable::cos(7 * x);
  }
  EXPECT_EQ(sum, 0x1.c493f50ed216fp+7) << fmt::format("{:a}", sum);
}

}  // namespace
}  // namespace musclebench

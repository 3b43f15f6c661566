#include "backends/sdf/grid/cubic_cell.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

CubicCell cell_of(const std::function<double(const Vec3&)>& function) {
  CubicCell cell;
  for (int axis = 0; axis < 3; ++axis) {
    const int first_other = axis == 0 ? 1 : 0;
    const int second_other = axis == 2 ? 1 : 2;
    for (int edge = 0; edge < 4; ++edge) {
      const auto at = [&](double along) {
        Vec3 point;
        point[axis] = along;
        point[first_other] = edge / 2;
        point[second_other] = edge % 2;
        return function(point);
      };
      CubicCell::Along& values = cell.axis[static_cast<std::size_t>(axis)];
      values.low[edge] = at(0);
      values.first[edge] = at(1.0 / 3);
      values.second[edge] = at(2.0 / 3);
      values.high[edge] = at(1);
    }
  }
  return cell;
}

class Random {
 public:
  double operator()() { return m_uniform(m_generator); }
  Vec3 point() {
    const double x = (*this)();
    const double y = (*this)();
    return {x, y, (*this)()};
  }

 private:
  std::mt19937 m_generator{5};
  std::uniform_real_distribution<double> m_uniform{0, 1};
};

/// Noise: each node has a value of its own, the same for every call with that node.
double noise(const Vec3& point) { return std::sin(1e3 * point.x() + 77 * point.y() + 5555 * point.z() + 1); }

/// The 32-node basis as the literature writes it, over [-1, 1]^3.
double textbook_value(const std::function<double(const Vec3&)>& nodes, const Vec3& at) {
  const Vec3 xi = 2 * at - Vec3::Ones();
  const auto unit = [](const Vec3& reference) { return Vec3(0.5 * (reference + Vec3::Ones())); };
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 node((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
    sum += nodes(unit(node)) / 64 * (1 + xi.x() * node.x()) * (1 + xi.y() * node.y()) * (1 + xi.z() * node.z()) *
           (9 * xi.squaredNorm() - 19);
  }
  for (int axis = 0; axis < 3; ++axis) {
    const int p = (axis + 1) % 3;
    const int q = (axis + 2) % 3;
    for (int edge = 0; edge < 8; ++edge) {
      Vec3 node;
      node[axis] = (edge & 1) != 0 ? 1.0 / 3 : -1.0 / 3;
      node[p] = (edge & 2) != 0 ? 1 : -1;
      node[q] = (edge & 4) != 0 ? 1 : -1;
      sum += nodes(unit(node)) * 9 / 64 * (1 - xi[axis] * xi[axis]) * (1 + 9 * xi[axis] * node[axis]) *
             (1 + xi[p] * node[p]) * (1 + xi[q] * node[q]);
    }
  }
  return sum;
}

/// Nodes come with rounding in their coordinates from both sides; snap to thirds.
double node_noise(const Vec3& point) { return noise((point * 3).array().round().matrix() / 3); }

TEST(CubicCell, IsTheTextbookBasis) {
  const CubicCell cell = cell_of(node_noise);
  Random random;
  for (int i = 0; i < 100; ++i) {
    const Vec3 at = random.point();
    EXPECT_NEAR(cell.value(at), textbook_value(node_noise, at), 1e-13);
  }
}

TEST(CubicCell, ReproducesEveryMonomialOfItsSpace) {
  Random random;
  int monomials = 0;
  for (int a = 0; a <= 3; ++a) {
    for (int b = 0; b <= 3; ++b) {
      for (int c = 0; c <= 3; ++c) {
        const int beyond_linear = (a > 1 ? a : 0) + (b > 1 ? b : 0) + (c > 1 ? c : 0);
        if (beyond_linear > 3) {
          continue;
        }
        ++monomials;
        const auto power = [](double x, int n) { return n == 0 ? 1.0 : std::pow(x, n); };
        const auto monomial = [&](const Vec3& p) { return power(p.x(), a) * power(p.y(), b) * power(p.z(), c); };
        const CubicCell cell = cell_of(monomial);
        for (int i = 0; i < 20; ++i) {
          const Vec3 at = random.point();
          EXPECT_NEAR(cell.value(at), monomial(at), 1e-14) << a << b << c;
        }
      }
    }
  }
  EXPECT_EQ(monomials, 32);
}

TEST(CubicCell, GradientIsTheDerivativeOfTheValue) {
  const CubicCell cell = cell_of(node_noise);
  Random random;
  for (int i = 0; i < 100; ++i) {
    const Vec3 at = random.point();
    Vec3 gradient;
    EXPECT_NEAR(cell.value_and_gradient(at, gradient), cell.value(at), 1e-14);
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double step = 1e-5;
      const Vec3 ahead = at + step * Vec3::Unit(axis);
      const Vec3 behind = at - step * Vec3::Unit(axis);
      EXPECT_NEAR(gradient[axis], (cell.value(ahead) - cell.value(behind)) / (2 * step), 1e-7);
    }
  }
}

TEST(CubicCell, NeverGoesBelowItsBound) {
  Random random;
  for (int shape = 0; shape < 200; ++shape) {
    const Vec3 shift = random.point();
    const CubicCell cell = cell_of([&](const Vec3& p) { return node_noise(p) + 3 * node_noise(p + shift); });
    double smallest = 1e300;
    constexpr int steps = 12;
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; j <= steps; ++j) {
        for (int k = 0; k <= steps; ++k) {
          const Vec3 at = Vec3(i, j, k) / steps;
          smallest = std::min(smallest, cell.value(at));
        }
      }
    }
    EXPECT_GE(smallest, cell.lower_bound() - 1e-12);
  }
}

TEST(CubicCell, NoGradientIsLongerThanTheLipschitzBound) {
  Random random;
  const Vec3 size(0.5, 2, 1.25);
  for (int shape = 0; shape < 200; ++shape) {
    const Vec3 shift = random.point();
    const CubicCell cell = cell_of([&](const Vec3& p) { return node_noise(p) + 3 * node_noise(p + shift); });
    const double lipschitz_bound = CubicCell::lipschitz_bound(cell.bernstein(), size);
    double found = 0;
    for (int sample = 0; sample < 9 * 9 * 9; ++sample) {
      Vec3 gradient;
      (void)cell.value_and_gradient(Vec3(sample % 9, sample / 9 % 9, sample / 81) / 8, gradient);
      found = std::max(found, gradient.cwiseQuotient(size).norm());
    }
    EXPECT_LE(found, lipschitz_bound * (1 + 1e-12));
    EXPECT_GE(found, 0.3 * lipschitz_bound);
  }
}

TEST(CubicCell, BernsteinCoefficientsAreThoseOfThePolynomial) {
  const CubicCell cell = cell_of(node_noise);
  const CubicCell::Bernstein coefficients = cell.bernstein();
  Random random;
  for (int i = 0; i < 50; ++i) {
    const Vec3 at = random.point();
    const auto basis = [](double t) {
      return std::array<double, 4>{std::pow(1 - t, 3), 3 * t * std::pow(1 - t, 2), 3 * t * t * (1 - t), t * t * t};
    };
    const auto x = basis(at.x()), y = basis(at.y()), z = basis(at.z());
    double sum = 0;
    for (std::size_t n = 0; n < 64; ++n) {
      sum += coefficients[n] * x[n / 16] * y[n / 4 % 4] * z[n % 4];
    }
    EXPECT_NEAR(sum, cell.value(at), 1e-13);
  }
}

TEST(CubicCell, BoundIsSharpForLinearFunctions) {
  const CubicCell cell = cell_of([](const Vec3& p) { return 2 + p.x() - 3 * p.y() + 0.5 * p.z(); });
  EXPECT_NEAR(cell.lower_bound(), -1, 1e-13);
  EXPECT_NEAR(CubicCell::lipschitz_bound(cell.bernstein(), Vec3::Ones()), Vec3(1, -3, 0.5).norm(), 1e-13);
}

}  // namespace
}  // namespace musclebench

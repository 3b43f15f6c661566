#include "backends/sdf/grid/cubic_cell.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace musclebench {

namespace {

using Edges = CubicCell::Edges;

/// What an edge's four values are multiplied with to give the bubble, or a derivative of it, at one point along the
/// edge. The bubble interpolates 0, first - line, second - line, 0, where line is the straight line between the
/// corners.
struct BubbleWeights {
  double low, first, second, high;

  [[nodiscard]] Edges apply(const CubicCell::Along& along) const {
    return low * along.low + first * along.first + second * along.second + high * along.high;
  }
};

BubbleWeights weights_of(double first, double second) {
  return {-(2 * first + second) / 3, first, second, -(first + 2 * second) / 3};
}

BubbleWeights bubble_at(double t) {
  const double cubic = 13.5 * t * (1 - t);
  return weights_of(cubic * (2.0 / 3 - t), cubic * (t - 1.0 / 3));
}

BubbleWeights bubble_slope_at(double t) { return weights_of(9 + t * (-45 + 40.5 * t), -4.5 + t * (36 - 40.5 * t)); }

/// The four products of {1 - p, p} and {1 - q, q}.
Edges bilinear(double p, double q) {
  const double pq = p * q;
  return {1 - p - q + pq, q - pq, p - pq, pq};
}

struct OtherAxes {
  int p, q;
};
constexpr std::array<OtherAxes, 3> others{{{1, 2}, {0, 2}, {0, 1}}};

}  // namespace

double CubicCell::value(const Vec3& at) const {
  Edges sum = axis[0].low + at[0] * (axis[0].high - axis[0].low);
  sum += bubble_at(at[0]).apply(axis[0]);
  double result = (sum * bilinear(at[1], at[2])).sum();
  for (std::size_t a = 1; a < 3; ++a) {
    const Edges blend = bilinear(at[others[a].p], at[others[a].q]);
    result += (bubble_at(at[static_cast<Eigen::Index>(a)]).apply(axis[a]) * blend).sum();
  }
  return result;
}

double CubicCell::value_and_gradient(const Vec3& at, Vec3& gradient) const {
  double result = 0;
  gradient.setZero();
  for (std::size_t a = 0; a < 3; ++a) {
    const auto along = static_cast<Eigen::Index>(a);
    const double p = at[others[a].p];
    const double q = at[others[a].q];
    Edges bubbles = bubble_at(at[along]).apply(axis[a]);
    Edges slopes = bubble_slope_at(at[along]).apply(axis[a]);
    if (a == 0) {  // the trilinear part joins the bubbles along x
      bubbles += axis[0].low + at[0] * (axis[0].high - axis[0].low);
      slopes += axis[0].high - axis[0].low;
    }
    const Edges blend = bilinear(p, q);
    result += (bubbles * blend).sum();
    gradient[along] += (slopes * blend).sum();
    gradient[others[a].p] += (bubbles * Edges(q - 1, -q, 1 - q, q)).sum();
    gradient[others[a].q] += (bubbles * Edges(p - 1, 1 - p, -p, p)).sum();
  }
  return result;
}

namespace {

/// A cubic bubble 3 t (1-t)^2 b1 + 3 t^2 (1-t) b2 has the Bernstein coefficients 0, b1, b2, 0.
std::array<Edges, 2> bubbles_of(const CubicCell::Along& edges) {
  const Edges rise = edges.high - edges.low;
  const Edges first = edges.first - edges.low - rise / 3;
  const Edges second = edges.second - edges.low - rise * 2 / 3;
  return {3 * first - 1.5 * second, 3 * second - 1.5 * first};
}

}  // namespace

CubicCell::Bernstein CubicCell::bernstein() const {
  // Across its edge a bubble is linear, and raising the degree of a linear function to 3 samples it at the thirds.
  const std::array<std::array<Edges, 2>, 3> bubble{bubbles_of(axis[0]), bubbles_of(axis[1]), bubbles_of(axis[2])};
  using Line = std::array<double, 4>;
  const auto third = [](int i) { return static_cast<double>(i) / 3; };
  // Four values at the corners of a square, along one side of it at the thirds of the other.
  const auto line = [&](const Edges& corners, double p) {
    const double from = corners[0] + p * (corners[2] - corners[0]);
    const double rise = corners[1] + p * (corners[3] - corners[1]) - from;
    return Line{from, from + rise * third(1), from + rise * third(2), from + rise};
  };
  Bernstein result;
  for (int x = 0; x < 4; ++x) {
    Edges linear = axis[0].low + third(x) * (axis[0].high - axis[0].low);
    if (x == 1 || x == 2) {
      linear += bubble[0][static_cast<std::size_t>(x - 1)];
    }
    std::array<Line, 2> of_z;
    for (std::size_t n = 0; n < 2; ++n) {
      of_z[n] = line(bubble[2][n], third(x));
    }
    for (int y = 0; y < 4; ++y) {
      Line sum = line(linear, third(y));
      if (y == 1 || y == 2) {
        const Line of_y = line(bubble[1][static_cast<std::size_t>(y - 1)], third(x));
        for (std::size_t z = 0; z < 4; ++z) {
          sum[z] += of_y[z];
        }
      }
      sum[1] += of_z[0][static_cast<std::size_t>(y)];
      sum[2] += of_z[1][static_cast<std::size_t>(y)];
      std::copy(sum.begin(), sum.end(), result.begin() + 16 * x + 4 * y);
    }
  }
  return result;
}

double CubicCell::lower_bound() const {
  const Bernstein coefficients = bernstein();
  return *std::min_element(coefficients.begin(), coefficients.end());
}

double CubicCell::lipschitz_bound(const Bernstein& coefficients, const Vec3& cell_size_m) {
  // A derivative has the coefficients 3 (next - this), and one degree less along its axis; raised again to 3, all three
  // stand at the same indices.
  std::array<double, 64> squared{};
  for (Eigen::Index a = 0; a < 3; ++a) {
    const std::size_t step = a == 0 ? 16 : (a == 1 ? 4 : 1);
    const double per_m = 3 / cell_size_m[a];
    for (std::size_t line = 0; line < 16; ++line) {
      const std::size_t start = a == 0 ? line : (a == 1 ? 16 * (line / 4) + line % 4 : 4 * line);
      const auto at = [&](std::size_t n) { return coefficients[start + n * step]; };
      const double d0 = (at(1) - at(0)) * per_m;
      const double d1 = (at(2) - at(1)) * per_m;
      const double d2 = (at(3) - at(2)) * per_m;
      const std::array<double, 4> raised{d0, (d0 + 2 * d1) / 3, (2 * d1 + d2) / 3, d2};
      for (std::size_t n = 0; n < 4; ++n) {
        squared[start + n * step] += raised[n] * raised[n];
      }
    }
  }
  return std::sqrt(*std::max_element(squared.begin(), squared.end()));
}

}  // namespace musclebench

#include "backends/sdf/cubic_cell.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace musclebench {

namespace {

using Edges = CubicCell::Edges;

/// What an edge's four values are multiplied with to give the bubble, or a derivative of it, at one place along the
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

double CubicCell::lower_bound_on_face(std::size_t face_axis, int side) const {
  std::array<std::size_t, 3> from{0, 0, 0};
  std::array<std::size_t, 3> to{3, 3, 3};
  from[face_axis] = to[face_axis] = side == 0 ? 0 : 3;
  return lower_bound(from, to);
}

double CubicCell::lower_bound(std::array<std::size_t, 3> from, std::array<std::size_t, 3> to) const {
  // A cubic bubble 3 t (1-t)^2 b1 + 3 t^2 (1-t) b2 has the Bernstein coefficients 0, b1, b2, 0. Across the edge it is
  // linear, and raising the degree of a linear function to 3 samples it at the thirds.
  std::array<std::array<Edges, 4>, 3> coefficients;
  for (std::size_t a = 0; a < 3; ++a) {
    const Along& edges = axis[a];
    const Edges rise = edges.high - edges.low;
    const Edges first = edges.first - edges.low - rise / 3;
    const Edges second = edges.second - edges.low - rise * 2 / 3;
    coefficients[a] = {Edges::Zero(), 3 * first - 1.5 * second, 3 * second - 1.5 * first, Edges::Zero()};
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const double t = static_cast<double>(i) / 3;
    coefficients[0][i] += axis[0].low + t * (axis[0].high - axis[0].low);
  }
  std::array<Edges, 16> blend;
  for (std::size_t i = 0; i < 16; ++i) {
    blend[i] = bilinear(static_cast<double>(i / 4) / 3, static_cast<double>(i % 4) / 3);
  }
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t x = from[0]; x <= to[0]; ++x) {
    for (std::size_t y = from[1]; y <= to[1]; ++y) {
      for (std::size_t z = from[2]; z <= to[2]; ++z) {
        const Edges sum = coefficients[0][x] * blend[4 * y + z] + coefficients[1][y] * blend[4 * x + z] +
                          coefficients[2][z] * blend[4 * x + y];
        lowest = std::min(lowest, sum.sum());
      }
    }
  }
  return lowest;
}

}  // namespace musclebench

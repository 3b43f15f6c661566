#include "backends/sdf/build/octree_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace musclebench {

namespace {

/// Least-squares weight of a derivative along the cell's unit axes, relative to a value. Derivatives determine a fit of
/// 20 coefficients through 27 or 35 values, but are less reliable where the surface has an edge: there the gradient
/// jumps and the distance does not. On bones the error is about the same from 0.05 to 0.2 and grows above.
constexpr double gradient_weight = 0.1;

/// The largest distance of a point of a cell from the nearest sample, in edges; rounded up.
constexpr double reach_of_all = 0.27951;      // sqrt(5) / 8
constexpr double reach_of_lattice = 0.43302;  // sqrt(3) / 4

double power(double base, int exponent) {
  double result = 1;
  for (int i = 0; i < exponent; ++i) {
    result *= base;
  }
  return result;
}

double term_at(std::size_t term, const Vec3& at) {
  const auto& [x, y, z] = polynomial_powers[term];
  return power(at[0], x) * power(at[1], y) * power(at[2], z);
}

double slope_at(std::size_t term, const Vec3& at, std::size_t axis) {
  double result = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    const int exponent = polynomial_powers[term][a];
    const double along = at[static_cast<Eigen::Index>(a)];
    result *= a == axis ? (exponent == 0 ? 0 : exponent * power(along, exponent - 1)) : power(along, exponent);
  }
  return result;
}

using SampleValues = std::array<double, padded_samples>;

/// The largest error where value and error are both positive, plus the given slack.
double largest_excess_m(const CellErrors& error_m, const SampleValues& value_m, double more_m) {
  double largest_m = 0;
  for (std::size_t sample = 0; sample < padded_samples; ++sample) {
    const double above_m = static_cast<double>(error_m[sample]) + more_m;
    largest_m = above_m > -value_m[sample] ? std::max(largest_m, above_m) : largest_m;
  }
  return largest_m;
}

}  // namespace

double PolynomialFit::value(const Vec3& at, std::size_t terms) const {
  Vec3 ignored;
  return terms == cubic_terms ? evaluate_polynomial<true>(coefficients.data(), at, ignored)
                              : evaluate_polynomial<false>(coefficients.data(), at, ignored);
}

double PolynomialFit::spread() const {
  double result = 0;
  for (std::size_t term = 1; term < cubic_terms; ++term) {
    result += std::abs(static_cast<double>(coefficients[term]));
  }
  return result;
}

double PolynomialFit::lipschitz_bound(double half_edge_m) const {
  // Every monomial and its derivatives over their exponents are within [-1, 1].
  double x = 0;
  double y = 0;
  double z = 0;
  for (std::size_t term = 0; term < cubic_terms; ++term) {
    const double size = std::abs(static_cast<double>(coefficients[term]));
    x += polynomial_powers[term][0] * size;
    y += polynomial_powers[term][1] * size;
    z += polynomial_powers[term][2] * size;
  }
  return std::sqrt(x * x + y * y + z * z) / half_edge_m;
}

template <std::size_t terms>
PolynomialFitter<terms>::PolynomialFitter() {
  for (std::size_t sample = 0; sample < cell_samples; ++sample) {
    for (std::size_t term = 0; term < terms; ++term) {
      m_powers[term][sample] = static_cast<float>(term_at(term, sample_position(sample)));
    }
  }
}

template <std::size_t terms>
auto PolynomialFitter<terms>::shares(std::size_t known) -> std::vector<Shares> {
  Eigen::MatrixXd equations(static_cast<Eigen::Index>(4 * known), static_cast<Eigen::Index>(terms));
  for (std::size_t sample = 0; sample < known; ++sample) {
    const Vec3 at = sample_position(sample);
    for (std::size_t term = 0; term < terms; ++term) {
      const auto row = static_cast<Eigen::Index>(4 * sample);
      const auto column = static_cast<Eigen::Index>(term);
      equations(row, column) = term_at(term, at);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        equations(row + 1 + static_cast<Eigen::Index>(axis), column) = gradient_weight * slope_at(term, at, axis);
      }
    }
  }
  const Eigen::MatrixXd solution = (equations.transpose() * equations).ldlt().solve(equations.transpose());
  std::vector<Shares> result(known);
  for (std::size_t sample = 0; sample < known; ++sample) {
    for (std::size_t part = 0; part < 4; ++part) {
      for (std::size_t term = 0; term < terms; ++term) {
        const double share = (part == 0 ? 1 : gradient_weight) *
                             solution(static_cast<Eigen::Index>(term), static_cast<Eigen::Index>(4 * sample + part));
        // By symmetry most are 0. Rounding leaves numbers so small that they are denormal floats, which are slow.
        constexpr double rounding = 1e-12;
        result[sample][part][term] = std::abs(share) < rounding ? 0 : static_cast<float>(share);
      }
    }
  }
  return result;
}

template <std::size_t terms>
PolynomialFit PolynomialFitter<terms>::fit(const CellSamples& samples, double half_edge_m) const {
  const double middle_m = samples[lattice_samples / 2].value_m;
  const auto half_edge = static_cast<float>(half_edge_m);
  const std::size_t known = known_samples(samples);
  const std::vector<Shares>& shares = known == cell_samples ? m_of_all : m_of_lattice;
  Row sum{};
  for (std::size_t sample = 0; sample < known; ++sample) {
    const DistanceSample& exact = samples[sample];
    const auto above_middle = static_cast<float>(exact.value_m - middle_m);
    const auto& [value, along_x, along_y, along_z] = shares[sample];
    const float dx = half_edge * exact.gradient[0];
    const float dy = half_edge * exact.gradient[1];
    const float dz = half_edge * exact.gradient[2];
    for (std::size_t term = 0; term < padded_terms; ++term) {
      sum[term] += value[term] * above_middle + along_x[term] * dx + along_y[term] * dy + along_z[term] * dz;
    }
  }
  PolynomialFit result;
  std::copy_n(sum.begin(), terms, result.coefficients.begin());
  result.coefficients[0] = static_cast<float>(sum[0] + middle_m);
  return result;
}

template <std::size_t terms>
CellErrors PolynomialFitter<terms>::measure(const CellSamples& samples, double half_edge_m, PolynomialFit& fit) const {
  const auto constant_m = static_cast<double>(fit.coefficients[0]);
  const std::size_t known = known_samples(samples);
  // Samples that are not known are deep inside, where nothing is positive.
  SampleValues value_m;
  value_m.fill(-std::numeric_limits<double>::infinity());
  CellErrors error_m{};
  for (std::size_t sample = 0; sample < known; ++sample) {
    value_m[sample] = samples[sample].value_m;
    error_m[sample] = static_cast<float>(constant_m - value_m[sample]);
  }
  for (std::size_t term = 1; term < terms; ++term) {
    const float coefficient = fit.coefficients[term];
    for (std::size_t sample = 0; sample < padded_samples; ++sample) {
      error_m[sample] += m_powers[term][sample] * coefficient;
    }
  }
  // The floats of an error are off by less: a cubic's coefficients sum up to some 48 half edges.
  fit.excess_m = largest_excess_m(error_m, value_m, 4e-5 * half_edge_m);
  std::fill(error_m.begin() + static_cast<std::ptrdiff_t>(known), error_m.end(), 0.0F);
  Eigen::Map<Eigen::Array<float, static_cast<int>(padded_samples), 1>> errors_m(error_m.data());
  errors_m = errors_m.abs();
  const float largest_m = errors_m.maxCoeff();
  // No point of the cell is farther than this from a sample. Along the path there the polynomial changes by its slope
  // and the distance by one metre a metre.
  const double reach_m = 2 * half_edge_m * (known == cell_samples ? reach_of_all : reach_of_lattice);
  fit.bound_m = (largest_m + reach_m * (1 + fit.lipschitz_bound(half_edge_m))) * (1 + 1e-5);
  return error_m;
}

template class PolynomialFitter<quadratic_terms>;
template class PolynomialFitter<cubic_terms>;

}  // namespace musclebench

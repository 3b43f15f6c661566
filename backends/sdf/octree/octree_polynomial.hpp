#pragma once

#include <array>
#include <cstddef>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A polynomial over [-1, 1]^3 by the coefficients of its monomials, lower degrees first; of one degree by the powers
/// of x downwards, then of y: 1; x, y, z; x^2, xy, xz, y^2, yz, z^2; x^3, x^2 y, ... z^3. So the first 10 are a
/// quadratic polynomial.
inline constexpr std::size_t quadratic_terms = 10;
inline constexpr std::size_t cubic_terms = 20;

/// Powers of x, y and z in each term.
inline constexpr std::array<std::array<int, 3>, cubic_terms> polynomial_powers{
    {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 2, 0}, {0, 1, 1}, {0, 0, 2},
     {3, 0, 0}, {2, 1, 0}, {2, 0, 1}, {1, 2, 0}, {1, 1, 1}, {1, 0, 2}, {0, 3, 0}, {0, 2, 1}, {0, 1, 2}, {0, 0, 3}}};

/// The polynomial's value and its derivatives at `at`. `c` holds `quadratic_terms` or `cubic_terms` coefficients.
template <bool cubic>
inline double evaluate_polynomial(const float* c, const Vec3& at, Vec3& gradient) {
  const double x = at[0], y = at[1], z = at[2];
  // In powers of x: a_n are polynomials in y and z, and b_n, d_n their derivatives along those.
  double a0 = c[0] + y * (c[2] + y * c[7] + z * c[8]) + z * (c[3] + z * c[9]);
  double a1 = c[1] + y * c[5] + z * c[6];
  double a2 = c[4];
  double b0 = c[2] + y * 2 * c[7] + z * c[8];
  double b1 = c[5];
  double d0 = c[3] + y * c[8] + z * 2 * c[9];
  double d1 = c[6];
  if constexpr (cubic) {
    a0 += y * y * (y * c[16] + z * c[17]) + z * z * (y * c[18] + z * c[19]);
    a1 += y * (y * c[13] + z * c[14]) + z * z * c[15];
    a2 += y * c[11] + z * c[12];
    b0 += y * (y * 3 * c[16] + z * 2 * c[17]) + z * z * c[18];
    b1 += y * 2 * c[13] + z * c[14];
    d0 += y * (y * c[17] + z * 2 * c[18]) + z * z * 3 * c[19];
    d1 += y * c[14] + z * 2 * c[15];
    const double a3 = c[10];
    gradient = {a1 + x * (2 * a2 + x * 3 * a3), b0 + x * (b1 + x * c[11]), d0 + x * (d1 + x * c[12])};
    return a0 + x * (a1 + x * (a2 + x * a3));
  } else {
    gradient = {a1 + x * 2 * a2, b0 + x * b1, d0 + x * d1};
    return a0 + x * (a1 + x * a2);
  }
}

}  // namespace musclebench

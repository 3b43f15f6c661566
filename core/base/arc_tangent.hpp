#pragma once

#include <array>

namespace musclebench {

/// atan(t) / t = 1 + u (c[0] + c[1] u + ...) with u = t^2, for |t| <= tan(pi / 8): the polynomial of least relative
/// error (Remez exchange), 1.2e-18 before rounding.
constexpr std::array<double, 11> arc_tangent_terms{-0.3333333333333313, 0.19999999999942733,  -0.14285714279416842,
                                                   0.11111110752660312, -0.09090897018976808, 0.07692048880900516,
                                                   -0.0666299037988197, 0.05847147496454094,  -0.05036269442015652,
                                                   0.03799385036795382, -0.01783565370219997};

/// tan(pi / 8): beyond it atan(t) = pi / 4 + atan((t - 1) / (t + 1)).
constexpr double arc_tangent_reach = 0.41421356237309503;

// pi / 4, pi / 2 and pi, each in two parts, so that a difference from them is rounded once.
constexpr double quarter_pi = 0.78539816339744828, quarter_pi_rest = 3.0616169978683830e-17;
constexpr double half_pi = 1.5707963267948966, half_pi_rest = 6.1232339957367660e-17;
constexpr double whole_pi = 3.1415926535897931, whole_pi_rest = 1.2246467991473532e-16;

/// The angle of (x, y) in (-pi, pi], off by less than 1e-15 rad; 0 for (0, 0). Sums, products and quotients only, none
/// fused: unlike `std::atan2`, the same bits on every CPU. arc_tangent-inl.hpp is the same for SIMD lanes.
double arc_tangent2(double y, double x);

}  // namespace musclebench

#include "core/base/portable_math.hpp"

#include <cmath>

// One lane of the same operations everywhere, and no fused multiply-add (-ffp-contract=off).
#undef HWY_COMPILE_ONLY_STATIC
#define HWY_COMPILE_ONLY_SCALAR
#include <hwy/highway.h>
// After highway.h.
#include <hwy/contrib/math/math-inl.h>

namespace musclebench::portable {

namespace {

namespace hn = hwy::HWY_NAMESPACE;
static_assert(HWY_TARGET == HWY_SCALAR);

constexpr hn::ScalableTag<double> lane;
constexpr double half_pi = 1.5707963267948966;
constexpr double whole_turn_rad = 4 * half_pi;

/// An angle less the nearest multiple of a quarter turn, which is at most pi / 4 away.
struct ReducedAngle {
  double rest_rad;
  int quarter_turns;  ///< modulo 4
};

ReducedAngle reduced(double angle_rad) {
  // A multiple below 2^20 times the first two parts of pi / 2, of 33 bits each, has no rounding error.
  constexpr double first = 0x1.921fb544p+0;
  constexpr double second = 0x1.0b4611a6p-34;
  constexpr double third = 0x1.3198a2e037073p-69;
  constexpr double reach_rad = 1e6;
  const double within_reach = std::abs(angle_rad) < reach_rad ? angle_rad : std::remainder(angle_rad, whole_turn_rad);
  const double multiple = std::nearbyint(within_reach / half_pi);
  return {((within_reach - multiple * first) - multiple * second) - multiple * third,
          static_cast<int>(static_cast<long long>(multiple) & 3)};
}

// Taylor series: at pi / 4 the first term that is left out is below a tenth of a unit in the last place.

double sine_near_zero(double x) {
  const double u = x * x;
  double sum = 0;
  for (const double divisor : {16 * 17, 14 * 15, 12 * 13, 10 * 11, 8 * 9, 6 * 7, 4 * 5, 2 * 3}) {
    sum = -u / divisor * (1 + sum);
  }
  return x + x * sum;
}

double cosine_near_zero(double x) {
  const double u = x * x;
  double sum = 0;
  for (const double divisor : {17 * 18, 15 * 16, 13 * 14, 11 * 12, 9 * 10, 7 * 8, 5 * 6, 3 * 4}) {
    sum = -u / divisor * (1 + sum);
  }
  return 1 - 0.5 * u * (1 + sum);
}

/// The sine of the angle plus so many quarter turns.
double sine_after(double angle_rad, int quarter_turns) {
  const ReducedAngle angle = reduced(angle_rad);
  switch ((angle.quarter_turns + quarter_turns) & 3) {
    case 0:
      return sine_near_zero(angle.rest_rad);
    case 1:
      return cosine_near_zero(angle.rest_rad);
    case 2:
      return -sine_near_zero(angle.rest_rad);
    default:
      return -cosine_near_zero(angle.rest_rad);
  }
}

}  // namespace

double exp(double x) { return hn::GetLane(hn::Exp(lane, hn::Set(lane, x))); }

double pow(double base, double exponent) {
  if (exponent == 0) return 1;
  if (base == 0) return exponent > 0 ? 0 : HUGE_VAL;
  return exp(exponent * hn::GetLane(hn::Log(lane, hn::Set(lane, base))));
}

double sin(double angle_rad) { return sine_after(angle_rad, 0); }

double cos(double angle_rad) { return sine_after(angle_rad, 1); }

}  // namespace musclebench::portable

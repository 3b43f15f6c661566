#include "core/distance/solid_angle_sum.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/arc_tangent.hpp"
#include "core/distance/triangle_distance.hpp"

namespace musclebench {

void SolidAngleSum::add(const Vec3& a, const Vec3& b, const Vec3& c) {
  const HalfAngleTangent half = half_solid_angle(m_point, a, b, c);
  if (half.opposite == 0) return;
  const double real = m_real * half.adjacent - m_imaginary * half.opposite;
  const double imaginary = m_imaginary * half.adjacent + m_real * half.opposite;
  const bool is_below = imaginary < 0;
  // Arguments are in (-pi, pi], and half a triangle's angle is less than pi: at most one passage.
  if (half.opposite > 0 && m_imaginary >= 0 && is_below) ++m_turns;
  if (half.opposite < 0 && m_imaginary < 0 && !is_below && (imaginary > 0 || real < 0)) --m_turns;
  const double size = std::max(std::abs(real), std::abs(imaginary));
  if (!(size > 0)) return;  // too small a triangle for its angle to be a number
  m_real = real / size;
  m_imaginary = imaginary / size;
}

double SolidAngleSum::steradians() const {
  return 2 * (2 * std::numbers::pi * m_turns + arc_tangent2(m_imaginary, m_real));
}

double SolidAngleSum::winding_number() const { return steradians() / (4 * std::numbers::pi); }

}  // namespace musclebench

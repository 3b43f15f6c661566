// The angle of a point, one a SIMD lane. Included by each file that is compiled once for every kind of SIMD, after
// highway.h. No product is fused with a sum, so that every kind gives the same bits.

#include "core/base/arc_tangent.hpp"

#if defined(MUSCLEBENCH_ARC_TANGENT_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef MUSCLEBENCH_ARC_TANGENT_INL
#undef MUSCLEBENCH_ARC_TANGENT_INL
#else
#define MUSCLEBENCH_ARC_TANGENT_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

/// `musclebench::arc_tangent2`.
template <typename Tag, typename Vec = hwy::HWY_NAMESPACE::Vec<Tag>>
HWY_INLINE Vec arc_tangent2(Tag d, Vec y, Vec x) {
  namespace hn = hwy::HWY_NAMESPACE;
  const auto set = [&](double value) { return hn::Set(d, value); };
  const Vec abs_x = hn::Abs(x);
  const Vec abs_y = hn::Abs(y);
  const Vec large = hn::Max(abs_x, abs_y);
  const Vec small = hn::Min(abs_x, abs_y);
  // One division for both ranges.
  const auto is_reduced = hn::Gt(small, hn::Mul(set(arc_tangent_reach), large));
  const Vec above = hn::IfThenElse(is_reduced, hn::Sub(small, large), small);
  const Vec below = hn::IfThenElse(is_reduced, hn::Add(small, large), large);
  const Vec t = hn::Div(above, hn::IfThenElse(hn::Gt(below, hn::Zero(d)), below, set(1)));

  // Estrin's scheme: Horner's would be a chain of eleven dependent operations.
  const Vec u = hn::Mul(t, t);
  const Vec u2 = hn::Mul(u, u);
  const Vec u4 = hn::Mul(u2, u2);
  const auto pair = [&](std::size_t i) {
    return hn::Add(set(arc_tangent_terms[i]), hn::Mul(u, set(arc_tangent_terms[i + 1])));
  };
  const auto four = [&](std::size_t i) { return hn::Add(pair(i), hn::Mul(u2, pair(i + 2))); };
  const Vec last = hn::Add(pair(8), hn::Mul(u2, set(arc_tangent_terms[10])));
  const Vec sum = hn::Add(four(0), hn::Mul(u4, hn::Add(four(4), hn::Mul(u4, last))));
  const Vec of_t = hn::Add(t, hn::Mul(hn::Mul(t, u), sum));

  Vec angle = hn::IfThenElse(is_reduced, hn::Add(set(quarter_pi), hn::Add(of_t, set(quarter_pi_rest))), of_t);
  angle = hn::IfThenElse(hn::Gt(abs_y, abs_x), hn::Sub(set(half_pi), hn::Sub(angle, set(half_pi_rest))), angle);
  angle = hn::IfThenElse(hn::Lt(x, hn::Zero(d)), hn::Sub(set(whole_pi), hn::Sub(angle, set(whole_pi_rest))), angle);
  return hn::CopySign(angle, y);
}

}  // namespace
}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

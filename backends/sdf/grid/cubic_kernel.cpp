#include "backends/sdf/grid/cubic_kernel.hpp"

#include <array>
#include <cstddef>

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "backends/sdf/grid/cubic_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "backends/sdf/grid/cell_values-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

/// Vectors of points whose values are fetched before their turn.
constexpr std::size_t fetched_ahead = 4;

/// Between four values at 00, 01, 10, 11 of p and q, with derivatives along both.
struct Blend {
  Vec value, of_p, of_q;
};

HWY_INLINE Blend blend(Vec v00, Vec v01, Vec v10, Vec v11, Vec p, Vec q) {
  const Vec low_q = hn::Sub(v01, v00);
  const Vec high_q = hn::Sub(v11, v10);
  const Vec low = add_product(v00, q, low_q);
  const Vec of_p = hn::Sub(add_product(v10, q, high_q), low);
  return {add_product(low, p, of_p), of_p, add_product(low_q, p, hn::Sub(high_q, low_q))};
}

/// Weights of the two nodes of an edge at t, and their slopes.
struct Weights {
  Vec first, second, first_slope, second_slope;
  Vec bubble;        ///< t (1 - t)
  Vec bubble_slope;  ///< of -4.5 t (1 - t)
};

HWY_INLINE Weights weights(Vec t) {
  const Vec bubble = hn::Mul(t, hn::Sub(set(1), t));
  const Vec bubble_slope = hn::Sub(hn::Mul(set(9), t), set(4.5));
  // 13.5 t (1 - t) (2/3 - t), and the same from the other end; their sum is 4.5 t (1 - t).
  const Vec first = hn::Mul(bubble, hn::Sub(set(9), hn::Mul(set(13.5), t)));
  const Vec first_slope = add_product(set(9), t, hn::Sub(hn::Mul(set(40.5), t), set(45)));
  return {first,       hn::Sub(hn::Mul(set(4.5), bubble), first),
          first_slope, hn::Sub(hn::Sub(set(0), bubble_slope), first_slope),
          bubble,      bubble_slope};
}

/// The part of the edges along one axis: value and derivatives along it and along the others.
struct Part {
  Vec value, along, of_p, of_q;
};

HWY_INLINE Part edges(const Weights& w, const Blend& first, const Blend& second) {
  return {sum_of_products(w.first, first.value, w.second, second.value),
          sum_of_products(w.first_slope, first.value, w.second_slope, second.value),
          sum_of_products(w.first, first.of_p, w.second, second.of_p),
          sum_of_products(w.first, first.of_q, w.second, second.of_q)};
}

HWY_INLINE void evaluate_lanes(const FieldView& field, const Runs& runs, FieldBlock& block, std::size_t first) {
  const auto [corner, at] = locate_in_cell(field, block, first);
  const auto& [x, y, z] = at;
  const Run r00 = load_run(field, runs, 0);
  const Run r01 = load_run(field, runs, 1);
  const Run r10 = load_run(field, runs, 2);
  const Run r11 = load_run(field, runs, 3);

  // The trilinear part of the corners.
  const Blend low = blend(r00.near, r01.near, r10.near, r11.near, y, z);
  const Blend high = blend(r00.far, r01.far, r10.far, r11.far, y, z);
  const Vec linear_x = hn::Sub(high.value, low.value);
  const Vec linear = add_product(low.value, x, linear_x);
  const Vec linear_y = add_product(low.of_p, x, hn::Sub(high.of_p, low.of_p));
  const Vec linear_z = add_product(low.of_q, x, hn::Sub(high.of_q, low.of_q));

  const Weights wx = weights(x), wy = weights(y), wz = weights(z);
  const Part of_x = edges(wx, blend(r00.x1, r01.x1, r10.x1, r11.x1, y, z), blend(r00.x2, r01.x2, r10.x2, r11.x2, y, z));
  const Part of_y = edges(wy, blend(r00.near_y1, r01.near_y1, r00.far_y1, r01.far_y1, x, z),
                          blend(r00.near_y2, r01.near_y2, r00.far_y2, r01.far_y2, x, z));
  const Part of_z = edges(wz, blend(r00.near_z1, r10.near_z1, r00.far_z1, r10.far_z1, x, y),
                          blend(r00.near_z2, r10.near_z2, r00.far_z2, r10.far_z2, x, y));

  // The trilinear part counts (9 |xi|^2 - 19) / 8 times, xi over [-1, 1]^3.
  const Vec scale = hn::Sub(set(1), hn::Mul(set(4.5), hn::Add(hn::Add(wx.bubble, wy.bubble), wz.bubble)));
  const auto total = [](Vec of_linear, Vec a, Vec b, Vec c)
                         HWY_ATTR { return hn::Add(of_linear, hn::Add(hn::Add(a, b), c)); };
  const Lanes d;
  hn::Store(total(hn::Mul(scale, linear), of_x.value, of_y.value, of_z.value), d, block.value_m.data() + first);
  const auto store_slope = [&](Vec v, double per_m, double* to)
                               HWY_ATTR { hn::Store(hn::Mul(v, set(per_m)), d, to + first); };
  store_slope(total(sum_of_products(scale, linear_x, wx.bubble_slope, linear), of_x.along, of_y.of_p, of_z.of_p),
              field.cells_per_m[0], block.slope_x.data());
  store_slope(total(sum_of_products(scale, linear_y, wy.bubble_slope, linear), of_x.of_p, of_y.along, of_z.of_q),
              field.cells_per_m[1], block.slope_y.data());
  store_slope(total(sum_of_products(scale, linear_z, wz.bubble_slope, linear), of_x.of_q, of_y.of_q, of_z.along),
              field.cells_per_m[2], block.slope_z.data());
}

void evaluate(const FieldView& field, FieldBlock& block) {
  std::array<Runs, fetched_ahead> runs;
  const std::size_t groups = (block.count + lane_count - 1) / lane_count;
  for (std::size_t group = 0; group < groups + fetched_ahead; ++group) {
    Runs& own = runs[group % fetched_ahead];
    if (group >= fetched_ahead) {
      evaluate_lanes(field, own, block, (group - fetched_ahead) * lane_count);
    }
    if (group < groups) {
      find_runs(field, locate_in_cell(field, block, group * lane_count).corner, own);
      fetch(field, own);
    }
  }
}

}  // namespace

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(evaluate);

void evaluate_block(const FieldView& field, FieldBlock& block) {
  if (block.count == 0) {
    return;
  }
  block.fill_last_vector();
  HWY_DYNAMIC_DISPATCH(evaluate)(field, block);
}

}  // namespace musclebench
#endif

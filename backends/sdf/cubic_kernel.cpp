#include "backends/sdf/cubic_kernel.hpp"

#include <cstddef>
#include <cstring>

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "backends/sdf/cubic_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

#ifndef MUSCLEBENCH_CUBIC_KERNEL_ONCE
#define MUSCLEBENCH_CUBIC_KERNEL_ONCE
namespace musclebench {

/// Queries whose values are fetched ahead of their turn.
constexpr std::size_t fetched_ahead = 4;

}  // namespace musclebench
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {

// Four lanes whatever the registers hold: Highway chooses the instructions, the compiler cuts the vectors to fit. So
// every machine rounds the same operations in the same order.
using Float4 [[gnu::vector_size(16)]] = float;
using Double4 [[gnu::vector_size(32)]] = double;
using Short4 [[gnu::vector_size(8)]] = std::int16_t;

template <typename Scalar>
struct VectorOf;
template <>
struct VectorOf<float> {
  using Type = Float4;
};
template <>
struct VectorOf<double> {
  using Type = Double4;
};

template <typename Vector, typename Scalar>
HWY_INLINE Vector load(const Scalar* from) {
  Vector result;
  std::memcpy(&result, from, sizeof result);
  return result;
}

HWY_INLINE Double4 widen(const Double4& vector) { return vector; }

HWY_INLINE Double4 widen(const Float4& vector) {
#if HWY_TARGET <= HWY_AVX2 && HWY_ARCH_X86
  return _mm256_cvtps_pd(vector);  // gcc makes two halves of the conversion below
#else
  return __builtin_convertvector(vector, Double4);
#endif
}

/// What a cell takes from one of its runs.
template <typename Vector>
struct Run {
  Vector near_yz;  ///< nodes on the edges that leave its first vertex: two along y, two along z
  Vector far_yz;   ///< the same of its second vertex
  Vector x;        ///< first vertex, two nodes, second vertex
};

template <typename Scalar>
struct PlainValues {
  using Vector = typename VectorOf<Scalar>::Type;

  HWY_INLINE Run<Vector> operator()(const void* run) const {
    const auto* values = static_cast<const Scalar*>(run);
    Vector x = load<Vector>(values + 4);
    x[0] = values[0];
    return {load<Vector>(values + 1), load<Vector>(values + 8), x};
  }
};

struct CompactValues {
  using Vector = Float4;
  Float4 yz_step;
  Float4 x_step;

  HWY_INLINE Run<Float4> operator()(const void* run) const {
    const auto* records = static_cast<const CompactRecord*>(run);
    const float own = records[0].own;
    const float next = records[1].own;
    const Float4 x = own + counted(records[0].steps.data() + 2) * x_step;  // only its last two lanes are along x
    return {own + counted(records[0].steps.data()) * yz_step, next + counted(records[1].steps.data()) * yz_step,
            Float4{own, x[2], x[3], next}};
  }

 private:
  HWY_INLINE static Float4 counted(const std::int16_t* steps) {
#if HWY_TARGET <= HWY_SSE4 && HWY_ARCH_X86
    return _mm_cvtepi32_ps(_mm_cvtepi16_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(steps))));
#else
    return __builtin_convertvector(load<Short4>(steps), Float4);
#endif
  }
};

/// Lanes: the edges along y, along z, the trilinear part, the edges along x. `first` and `second` hold the two nodes
/// of an edge, and the ends of an edge along x for the trilinear part.
struct Quad {
  Double4 first, second;
};

template <typename Vector>
HWY_INLINE Quad quad(const Vector& yz, const Vector& x) {
  return {widen(__builtin_shufflevector(yz, x, 0, 2, 4, 5)), widen(__builtin_shufflevector(yz, x, 1, 3, 7, 6))};
}

HWY_INLINE Double4 weighed(const Quad& edges, const Double4& first, const Double4& second) {
  return first * edges.first + second * edges.second;
}

template <typename Values>
HWY_INLINE void evaluate_cell(const CellQuery& query, const Values& values, CellAnswer& answer) {
  // Four edges stand side by side along each axis, at 00, 01, 10, 11 of the two other axes p and q.
  const auto r00 = values(query.run[0]);
  const auto r01 = values(query.run[1]);
  const auto r10 = values(query.run[2]);
  const auto r11 = values(query.run[3]);
  const Quad e00 = quad(r00.near_yz, r00.x);
  const Quad e01 = quad(__builtin_shufflevector(r01.near_yz, r10.near_yz, 0, 1, 6, 7), r01.x);
  const Quad e10 = quad(r00.far_yz, r10.x);
  const Quad e11 = quad(__builtin_shufflevector(r01.far_yz, r10.far_yz, 0, 1, 6, 7), r11.x);

  const double x = query.at[0], y = query.at[1], z = query.at[2];
  const Double4 along{y, z, x, x};
  const Double4 p{x, x, y, y};
  const Double4 q{z, y, z, z};

  // Weights of the two nodes of an edge and their slopes; between the ends of an edge along x the weights are linear.
  const Double4 rest = 1.0 - along;
  const Double4 bubble = 13.5 * along * rest;
  const Double4 rising{0, 0, 1, 0};
  Double4 first = bubble * (2.0 / 3 - along);
  Double4 second = bubble * (along - 1.0 / 3);
  Double4 first_slope = 9.0 + along * (40.5 * along - 45.0);
  Double4 second_slope = along * (36.0 - 40.5 * along) - 4.5;
  first = __builtin_shufflevector(first, rest, 0, 1, 6, 3);
  second = __builtin_shufflevector(second, along, 0, 1, 6, 3);
  first_slope = __builtin_shufflevector(first_slope, -rising, 0, 1, 6, 3);
  second_slope = __builtin_shufflevector(second_slope, rising, 0, 1, 6, 3);

  // Along the edges, then across them.
  const Double4 v00 = weighed(e00, first, second);
  const Double4 v10 = weighed(e10, first, second);
  const Double4 v00_q = weighed(e01, first, second) - v00;
  const Double4 v10_q = weighed(e11, first, second) - v10;
  const Double4 v0 = v00 + q * v00_q;
  const Double4 value_p = v10 + q * v10_q - v0;
  const Double4 value = v0 + p * value_p;
  const Double4 value_q = v00_q + p * (v10_q - v00_q);
  const Double4 s00 = weighed(e00, first_slope, second_slope);
  const Double4 s10 = weighed(e10, first_slope, second_slope);
  const Double4 s0 = s00 + q * (weighed(e01, first_slope, second_slope) - s00);
  const Double4 s1 = s10 + q * (weighed(e11, first_slope, second_slope) - s10);
  const Double4 slope = s0 + p * (s1 - s0);

  // Value and gradient of each part: the trilinear one counts (9 |xi|^2 - 19) / 8 times, xi over [-1, 1]^3.
  const Double4 of_y{value[0], value_p[0], slope[0], value_q[0]};
  const Double4 of_z{value[1], value_p[1], value_q[1], slope[1]};
  const Double4 linear{value[2], slope[2], value_p[2], value_q[2]};
  const Double4 of_x{value[3], slope[3], value_p[3], value_q[3]};
  const double scale = 1 - 4.5 * ((x * (1 - x) + y * (1 - y)) + z * (1 - z));
  const Double4 scale_slope{0, 9 * x - 4.5, 9 * y - 4.5, 9 * z - 4.5};
  const Double4 sum = (scale * linear + value[2] * scale_slope) + ((of_x + of_y) + of_z);
  std::memcpy(&answer, &sum, sizeof sum);
}

template <typename Values>
HWY_INLINE void evaluate_all(const CellQuery* queries, std::size_t count, const Values& values, CellAnswer* answers) {
  for (std::size_t i = 0; i < count; ++i) {
    if (i + fetched_ahead < count) {
      for (const void* run : queries[i + fetched_ahead].run) {
        __builtin_prefetch(run);
      }
    }
    evaluate_cell(queries[i], values, answers[i]);
  }
}

void evaluate_single(const CellQuery* queries, std::size_t count, CellAnswer* answers) {
  evaluate_all(queries, count, PlainValues<float>(), answers);
}

void evaluate_double(const CellQuery* queries, std::size_t count, CellAnswer* answers) {
  evaluate_all(queries, count, PlainValues<double>(), answers);
}

void evaluate_compact(const CellQuery* queries, std::size_t count, const float* steps, CellAnswer* answers) {
  const CompactValues values{{steps[0], steps[1], steps[2], steps[3]}, {0, 0, steps[4], steps[5]}};
  evaluate_all(queries, count, values, answers);
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(evaluate_single);
HWY_EXPORT(evaluate_double);
HWY_EXPORT(evaluate_compact);

static_assert(sizeof(CellAnswer) == 4 * sizeof(double), "written as one vector");

void evaluate_cells(FieldPrecision precision, const CompactSteps& steps, std::span<const CellQuery> queries,
                    std::span<CellAnswer> answers) {
  switch (precision) {
    case FieldPrecision::compact:
      HWY_DYNAMIC_DISPATCH(evaluate_compact)(queries.data(), queries.size(), steps.data(), answers.data());
      break;
    case FieldPrecision::single_precision:
      HWY_DYNAMIC_DISPATCH(evaluate_single)(queries.data(), queries.size(), answers.data());
      break;
    case FieldPrecision::double_precision:
      HWY_DYNAMIC_DISPATCH(evaluate_double)(queries.data(), queries.size(), answers.data());
      break;
  }
}

}  // namespace musclebench
#endif

#include "backends/sdf/build/rough_bounds.hpp"

#include "backends/sdf/grid/grid_shape.hpp"

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "backends/sdf/build/rough_bounds.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, RoughBounds::padding>;
using Places = hn::RebindToSigned<Lanes>;
using Vec = hn::Vec<Lanes>;
using Floats = RoughBounds::Floats;

/// Of edges along one axis: the largest bubble coefficient, and the largest rise between neighbours of the four
/// coefficients.
struct EdgeBounds {
  Vec bubble, rise;

  HWY_INLINE EdgeBounds() : bubble(hn::Zero(Lanes())), rise(hn::Zero(Lanes())) {}

  /// Values at the ends of an edge and at its thirds.
  HWY_INLINE void add(Vec low, Vec first, Vec second, Vec high) {
    const Lanes d;
    const Vec three = hn::Set(d, 3.0F);
    const Vec half_more = hn::Set(d, 1.5F);
    const Vec third = hn::Set(d, 1.0F / 3);
    const Vec a = hn::Sub(first, low);
    const Vec b = hn::Sub(second, low);
    const Vec c = hn::Sub(high, low);
    const Vec one = hn::MulSub(three, a, hn::Mul(half_more, b));
    const Vec two = hn::NegMulAdd(half_more, hn::Add(a, c), hn::Mul(three, b));
    bubble = hn::Max(bubble, hn::Max(hn::Abs(one), hn::Abs(two)));
    const Vec before = hn::Abs(hn::MulAdd(c, third, one));
    const Vec between = hn::Abs(hn::MulAdd(c, third, hn::Sub(two, one)));
    const Vec after = hn::Abs(hn::MulSub(c, third, two));
    rise = hn::Max(rise, hn::Max(before, hn::Max(between, after)));
  }
};

/// What vertices share with the cells on both sides along x.
struct VertexBounds {
  alignas(64) std::array<Floats, 4> value;  ///< of each row
  alignas(64) Floats y_bubble, y_rise, z_bubble, z_rise;
};

HWY_INLINE Vec load(const Floats& lanes, std::size_t first) { return hn::LoadU(Lanes(), lanes.data() + first); }

/// Where records begin; those beyond the `last` one repeat it.
HWY_INLINE hn::Vec<Places> records_from(std::size_t first, std::size_t last) {
  const Places d;
  const auto vertex =
      hn::Min(hn::Iota(d, static_cast<std::int32_t>(first)), hn::Set(d, static_cast<std::int32_t>(last)));
  return hn::Mul(vertex, hn::Set(d, static_cast<std::int32_t>(GridShape::record_size)));
}

HWY_INLINE void bound_vertices(const CellRows& rows, std::size_t count, VertexBounds& bounds) {
  const Lanes d;
  for (std::size_t first = 0; first <= count; first += hn::Lanes(d)) {
    const auto at = records_from(first, count);
    const auto value = [&](std::size_t row, std::size_t offset)
                           HWY_ATTR { return hn::GatherIndex(d, rows[row] + offset, at); };
    const Vec near = value(0, 0);
    const Vec above = value(1, 0);
    const Vec beyond = value(2, 0);
    const Vec far = value(3, 0);
    EdgeBounds y;
    y.add(near, value(0, 1), value(0, 2), beyond);
    y.add(above, value(1, 1), value(1, 2), far);
    EdgeBounds z;
    z.add(near, value(0, 3), value(0, 4), above);
    z.add(beyond, value(2, 3), value(2, 4), far);
    hn::StoreU(near, d, bounds.value[0].data() + first);
    hn::StoreU(above, d, bounds.value[1].data() + first);
    hn::StoreU(beyond, d, bounds.value[2].data() + first);
    hn::StoreU(far, d, bounds.value[3].data() + first);
    hn::StoreU(y.bubble, d, bounds.y_bubble.data() + first);
    hn::StoreU(y.rise, d, bounds.y_rise.data() + first);
    hn::StoreU(z.bubble, d, bounds.z_bubble.data() + first);
    hn::StoreU(z.rise, d, bounds.z_rise.data() + first);
  }
}

}  // namespace

void roughly(const CellRows& rows, std::size_t count, const std::array<float, 3>& thrice_per_m, RoughBounds& bounds) {
  const Lanes d;
  VertexBounds vertices;
  bound_vertices(rows, count, vertices);
  for (std::size_t first = 0; first < count; first += hn::Lanes(d)) {
    const auto at = records_from(first, count - 1);
    const auto larger = [&](const Floats& lanes)
                            HWY_ATTR { return hn::Max(load(lanes, first), load(lanes, first + 1)); };
    EdgeBounds x;
    Vec lowest = load(vertices.value[0], first);
    Vec largest = hn::Zero(d);
    for (std::size_t row = 0; row < rows.size(); ++row) {
      const Vec low = load(vertices.value[row], first);
      const Vec high = load(vertices.value[row], first + 1);
      x.add(low, hn::GatherIndex(d, rows[row] + 5, at), hn::GatherIndex(d, rows[row] + 6, at), high);
      lowest = hn::Min(lowest, hn::Min(low, high));
      largest = hn::Max(largest, hn::Max(hn::Abs(low), hn::Abs(high)));
    }
    const Vec y_bubble = larger(vertices.y_bubble);
    const Vec z_bubble = larger(vertices.z_bubble);
    const Vec bubbles = hn::Add(x.bubble, hn::Add(y_bubble, z_bubble));
    const Vec rounding = hn::Mul(hn::Add(largest, bubbles), hn::Set(d, RoughBounds::rounding));
    // Coefficients are values between those of the corners, and a bubble of each axis. Across their axis bubbles are
    // linear: from one coefficient to the next they change by a third of what they differ by at most.
    const auto slope = [&](Vec rise, Vec one, Vec other, std::size_t axis) HWY_ATTR {
      return hn::Mul(hn::MulAdd(hn::Add(one, other), hn::Set(d, 2.0F / 3), rise), hn::Set(d, thrice_per_m[axis]));
    };
    const Vec along_x = slope(x.rise, y_bubble, z_bubble, 0);
    const Vec along_y = slope(larger(vertices.y_rise), x.bubble, z_bubble, 1);
    const Vec along_z = slope(larger(vertices.z_rise), x.bubble, y_bubble, 2);
    hn::StoreU(lowest, d, bounds.lowest_corner.data() + first);
    hn::StoreU(hn::Sub(hn::Sub(lowest, bubbles), rounding), d, bounds.lowest.data() + first);
    hn::StoreU(hn::Sqrt(hn::MulAdd(along_z, along_z, hn::MulAdd(along_y, along_y, hn::Mul(along_x, along_x)))), d,
               bounds.steepest.data() + first);
  }
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(roughly);

void bound_roughly(const CellRows& rows, std::size_t count, const Vec3& cell_size_m, RoughBounds& bounds) {
  std::array<float, 3> thrice_per_m{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    thrice_per_m[axis] = static_cast<float>(3 / cell_size_m[static_cast<Eigen::Index>(axis)]);
  }
  HWY_DYNAMIC_DISPATCH(roughly)(rows, count, thrice_per_m, bounds);
}

}  // namespace musclebench
#endif

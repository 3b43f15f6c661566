#include "backends/sdf/build/cell_bounds.hpp"

#include <algorithm>

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "backends/sdf/build/cell_bounds.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

namespace musclebench {

#ifndef MUSCLEBENCH_CELL_LANES
#define MUSCLEBENCH_CELL_LANES
/// The same number of each cell.
using CellLanes = std::array<double, CellBounds::width>;

/// CubicCell's arrays, cell by cell in the lanes.
struct alignas(64) CellsInLanes {
  std::array<std::array<std::array<CellLanes, 4>, 4>, 3> axis;  ///< low, first, second, high; edge
};
#endif

}  // namespace musclebench

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<double, CellBounds::width>;
using Vec = hn::Vec<Lanes>;

HWY_INLINE Vec at(const CellLanes& lanes, std::size_t first) { return hn::Load(Lanes(), lanes.data() + first); }

HWY_INLINE Vec third(std::size_t i) { return hn::Set(Lanes(), static_cast<double>(i) / 3); }

/// As in CubicCell::bernstein: four values at the corners of a square, along one side of it at the thirds of the other.
struct Line {
  Vec v0, v1, v2, v3;

  HWY_INLINE Line(Vec c0, Vec c1, Vec c2, Vec c3, std::size_t p) {
    v0 = hn::Add(c0, hn::Mul(third(p), hn::Sub(c2, c0)));
    const Vec rise = hn::Sub(hn::Add(c1, hn::Mul(third(p), hn::Sub(c3, c1))), v0);
    v1 = hn::Add(v0, hn::Mul(rise, third(1)));
    v2 = hn::Add(v0, hn::Mul(rise, third(2)));
    v3 = hn::Add(v0, rise);
  }
  HWY_INLINE void add(const Line& other) {
    v0 = hn::Add(v0, other.v0);
    v1 = hn::Add(v1, other.v1);
    v2 = hn::Add(v2, other.v2);
    v3 = hn::Add(v3, other.v3);
  }
};

/// The two bubble coefficients of the edges along an axis.
HWY_INLINE void find_bubbles(const std::array<std::array<CellLanes, 4>, 4>& edges, std::size_t from,
                             std::array<std::array<CellLanes, 4>, 2>& bubble) {
  const Lanes d;
  for (std::size_t edge = 0; edge < 4; ++edge) {
    const Vec low = at(edges[0][edge], from);
    const Vec rise = hn::Sub(at(edges[3][edge], from), low);
    const Vec first = hn::Sub(hn::Sub(at(edges[1][edge], from), low), hn::Div(rise, hn::Set(d, 3.0)));
    const Vec second =
        hn::Sub(hn::Sub(at(edges[2][edge], from), low), hn::Div(hn::Mul(rise, hn::Set(d, 2.0)), hn::Set(d, 3.0)));
    const Vec three = hn::Set(d, 3.0);
    const Vec half_more = hn::Set(d, 1.5);
    hn::Store(hn::Sub(hn::Mul(three, first), hn::Mul(half_more, second)), d, bubble[0][edge].data() + from);
    hn::Store(hn::Sub(hn::Mul(three, second), hn::Mul(half_more, first)), d, bubble[1][edge].data() + from);
  }
}

HWY_INLINE Line line_of(const std::array<CellLanes, 4>& corners, std::size_t from, std::size_t p) {
  return {at(corners[0], from), at(corners[1], from), at(corners[2], from), at(corners[3], from), p};
}

/// Between neighbours along the axis on which coefficients stand `step` apart.
template <std::size_t step>
HWY_INLINE Vec largest_rise(const std::array<CellLanes, 64>& coefficient, std::size_t from) {
  Vec largest = hn::Zero(Lanes());
  for (std::size_t line = 0; line < 64; line += 4 * step) {
    for (std::size_t index = line; index < line + 3 * step; ++index) {
      const Vec rise = hn::Sub(at(coefficient[index + step], from), at(coefficient[index], from));
      largest = hn::Max(largest, hn::Abs(rise));
    }
  }
  return largest;
}

}  // namespace

void bound(const CellsInLanes& cells, const std::array<double, 3>& cell_size_m, CellBounds& bounds) {
  const Lanes d;
  alignas(64) std::array<std::array<std::array<CellLanes, 4>, 2>, 3> bubble;
  alignas(64) std::array<CellLanes, 64> coefficient;
  for (std::size_t from = 0; from < CellBounds::width; from += hn::Lanes(d)) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      find_bubbles(cells.axis[axis], from, bubble[axis]);
    }
    alignas(64) std::array<std::array<CellLanes, 4>, 2> of_z;
    for (std::size_t x = 0; x < 4; ++x) {
      alignas(64) std::array<CellLanes, 4> plane;
      for (std::size_t edge = 0; edge < 4; ++edge) {
        const Vec low = at(cells.axis[0][0][edge], from);
        Vec value = hn::Add(low, hn::Mul(third(x), hn::Sub(at(cells.axis[0][3][edge], from), low)));
        if (x == 1 || x == 2) {
          value = hn::Add(value, at(bubble[0][x - 1][edge], from));
        }
        hn::Store(value, d, plane[edge].data() + from);
      }
      for (std::size_t n = 0; n < 2; ++n) {
        const Line line = line_of(bubble[2][n], from, x);
        hn::Store(line.v0, d, of_z[n][0].data() + from);
        hn::Store(line.v1, d, of_z[n][1].data() + from);
        hn::Store(line.v2, d, of_z[n][2].data() + from);
        hn::Store(line.v3, d, of_z[n][3].data() + from);
      }
      for (std::size_t y = 0; y < 4; ++y) {
        Line sum = line_of(plane, from, y);
        if (y == 1 || y == 2) {
          sum.add(line_of(bubble[1][y - 1], from, x));
        }
        const std::size_t index = 16 * x + 4 * y;
        hn::Store(sum.v0, d, coefficient[index].data() + from);
        hn::Store(hn::Add(sum.v1, at(of_z[0][y], from)), d, coefficient[index + 1].data() + from);
        hn::Store(hn::Add(sum.v2, at(of_z[1][y], from)), d, coefficient[index + 2].data() + from);
        hn::Store(sum.v3, d, coefficient[index + 3].data() + from);
      }
    }
    Vec lowest = at(coefficient[0], from);
    Vec highest = lowest;
    for (const CellLanes& lanes : coefficient) {
      lowest = hn::Min(lowest, at(lanes, from));
      highest = hn::Max(highest, at(lanes, from));
    }
    hn::Store(lowest, d, bounds.lowest.data() + from);
    hn::Store(highest, d, bounds.highest.data() + from);
    // Raised to one degree, coefficients of a derivative are means of those before.
    const std::array<Vec, 3> rise{largest_rise<16>(coefficient, from), largest_rise<4>(coefficient, from),
                                  largest_rise<1>(coefficient, from)};
    Vec squared = hn::Zero(d);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Vec slope = hn::Mul(rise[axis], hn::Set(d, 3 / cell_size_m[axis]));
      squared = hn::Add(squared, hn::Mul(slope, slope));
    }
    hn::Store(hn::Sqrt(squared), d, bounds.lipschitz_bound.data() + from);
  }
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(bound);

void bound_cells(std::span<const CubicCell> cells, const Vec3& cell_size_m, CellBounds& bounds) {
  CellsInLanes lanes;
  for (std::size_t lane = 0; lane < CellBounds::width; ++lane) {
    const CubicCell& cell = cells[std::min(lane, cells.size() - 1)];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const CubicCell::Along& along = cell.axis[axis];
      for (std::size_t edge = 0; edge < 4; ++edge) {
        const auto e = static_cast<Eigen::Index>(edge);
        lanes.axis[axis][0][edge][lane] = along.low[e];
        lanes.axis[axis][1][edge][lane] = along.first[e];
        lanes.axis[axis][2][edge][lane] = along.second[e];
        lanes.axis[axis][3][edge][lane] = along.high[e];
      }
    }
  }
  HWY_DYNAMIC_DISPATCH(bound)(lanes, {cell_size_m.x(), cell_size_m.y(), cell_size_m.z()}, bounds);
}

}  // namespace musclebench
#endif

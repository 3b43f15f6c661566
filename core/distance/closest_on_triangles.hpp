#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/distance/triangle_distance.hpp"

namespace musclebench {

/// Closest points of eight pairs of a point and a triangle, as a structure of arrays.
struct ClosestOnTriangles {
  static constexpr std::size_t width = 8;
  alignas(64) std::array<double, width> squared_distance_m2;
  alignas(64) std::array<double, width> x, y, z;
  alignas(64) std::array<std::int64_t, width> feature;

  [[nodiscard]] ClosestOnTriangle at(std::size_t lane) const {
    return {{x[lane], y[lane], z[lane]}, squared_distance_m2[lane], static_cast<Feature>(feature[lane])};
  }
};

/// `closest_on_triangle` for many pairs of a point and a triangle with SIMD, with the same bits. Pair i is
/// `points[point[i]]` and `corners[triangle[i]]`; its result is lane i % 8 of `found[i / 8]`. The number of pairs is a
/// multiple of eight: the caller pads with repeated ones.
void closest_on_triangles(const Vec3* points, const std::array<Vec3, 3>* corners, std::span<const std::int32_t> point,
                          std::span<const std::int32_t> triangle, std::span<ClosestOnTriangles> found);

}  // namespace musclebench

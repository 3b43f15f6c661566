#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/distance/triangle_distance.hpp"

namespace musclebench {

/// The closest points of eight triangles to a point each.
struct ClosestOnTriangles {
  static constexpr std::size_t width = 8;
  alignas(64) std::array<double, width> squared_distance_m2;
  alignas(64) std::array<double, width> x, y, z;
  alignas(64) std::array<std::int64_t, width> feature;

  [[nodiscard]] ClosestOnTriangle at(std::size_t place) const {
    return {{x[place], y[place], z[place]}, squared_distance_m2[place], static_cast<Feature>(feature[place])};
  }
};

/// What `closest_on_triangle` says of pairs of a point and a triangle, to the bit, eight of them side by side.
/// `point` and `triangle` number them: a whole multiple of eight (those that are not needed may repeat others), for
/// which `found` has room.
void closest_on_triangles(const Vec3* points, const std::array<Vec3, 3>* corners, std::span<const std::int32_t> point,
                          std::span<const std::int32_t> triangle, std::span<ClosestOnTriangles> found);

}  // namespace musclebench

#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/bvh/triangle_bvh.hpp"
#include "core/distance/closest_on_triangles.hpp"

namespace musclebench {

/// The triangles nearest to a place, enough to find the closest one for points about that place without a search: a
/// triangle at distance d from the place is at least d less the way from there to the point. (What molecular dynamics
/// calls a Verlet list.)
struct NearTriangles {
  static constexpr std::size_t capacity = 32;
  static_assert(capacity % ClosestOnTriangles::width == 0);

  Vec3 place = Vec3::Zero();                     ///< rest frame
  double complete_m = 0;                         ///< whatever is not in the list is at least this far from the place
  std::size_t count = 0;                         ///< ascending by distance; none: nothing is known
  std::array<float, capacity> distance_m;        ///< not more than the true one
  std::array<std::int32_t, capacity> triangles;  ///< up to a whole multiple of eight the last one is repeated

  [[nodiscard]] bool empty() const { return count == 0; }
  void clear() { count = 0; }
};

/// The closest of triangles that come eight by eight; of several at the smallest squared distance the one with the
/// smallest index.
class ClosestOfMany {
 public:
  ClosestOfMany(const Vec3& point, const std::array<Vec3, 3>* corners) : m_point(point), m_corners(corners) {}

  void take(const std::int32_t* eight) {
    static constexpr std::array<std::int32_t, ClosestOnTriangles::width> the_point = {};
    ClosestOnTriangles found;
    closest_on_triangles(&m_point, m_corners, the_point, {eight, ClosestOnTriangles::width}, {&found, 1});
    int best = -1;
    for (std::size_t i = 0; i < ClosestOnTriangles::width; ++i) {
      const double squared_m2 = found.squared_distance_m2[i];
      if (squared_m2 < m_squared_m2 || (squared_m2 == m_squared_m2 && eight[i] < m_triangle)) {
        m_squared_m2 = squared_m2;
        m_triangle = eight[i];
        best = static_cast<int>(i);
      }
    }
    if (best >= 0) {
      m_closest = found.at(static_cast<std::size_t>(best));
    }
  }

  [[nodiscard]] double squared_distance_m2() const { return m_squared_m2; }
  [[nodiscard]] ClosestPoint answer() const {
    return {m_closest.point, std::sqrt(m_squared_m2), m_triangle, m_closest.feature};
  }

 private:
  const Vec3& m_point;
  const std::array<Vec3, 3>* m_corners;
  double m_squared_m2 = std::numeric_limits<double>::infinity();
  int m_triangle = -1;
  ClosestOnTriangle m_closest;
};

}  // namespace musclebench

#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "core/geometry/triangle_tree.hpp"

namespace musclebench {

struct NearTriangle {
  int triangle = -1;
  float distance_m = 0;  ///< not more than the true one
};

/// The triangles nearest to a place, enough to find the closest one for points about that place without a search: a
/// triangle at distance d from the place is at least d less the way from there to the point. (What molecular dynamics
/// calls a Verlet list.)
struct NearTriangles {
  static constexpr std::size_t capacity = 32;

  Vec3 place = Vec3::Zero();  ///< rest frame
  double complete_m = 0;      ///< whatever is not in the list is at least this far from the place
  std::array<NearTriangle, capacity> nearest;
  std::size_t count = 0;  ///< ascending by distance; none: nothing is known
};

/// `closest_on(triangle)` gives the ClosestOnTriangle of `point`. The list is not empty.
template <typename ClosestOn>
ListedClosest closest_listed(const NearTriangles& list, const Vec3& point, const ClosestOn& closest_on) {
  constexpr double slack = 1e-12;  // above the rounding of the distances compared
  const double moved_m = (point - list.place).norm() * (1 + slack);
  double best_m = std::numeric_limits<double>::infinity();
  ClosestOnTriangle best;
  best.squared_distance_m2 = best_m;
  int triangle = -1;
  for (const NearTriangle& near : std::span(list.nearest).first(list.count)) {
    if (static_cast<double>(near.distance_m) - moved_m > best_m) {
      break;
    }
    const ClosestOnTriangle candidate = closest_on(near.triangle);
    if (candidate.squared_distance_m2 < best.squared_distance_m2 ||
        (candidate.squared_distance_m2 == best.squared_distance_m2 && near.triangle < triangle)) {
      best = candidate;
      triangle = near.triangle;
      best_m = std::sqrt(best.squared_distance_m2) * (1 + slack);
    }
  }
  return {{best.point, std::sqrt(best.squared_distance_m2), triangle, best.feature},
          best_m < list.complete_m - moved_m};
}

}  // namespace musclebench

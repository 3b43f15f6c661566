#include "core/distance/triangle_separation.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

namespace musclebench {

namespace {

/// Fraction of the margin by which a triangle that touches the plane may cross it by rounding.
constexpr double touch_fraction = 1e-4;

/// Two triangles, shared corners first, relative to one of the corners.
struct Pair {
  std::array<std::array<Vec3, 3>, 2> corners;
  std::size_t shared = 0;
  double margin = 0;
};

Pair shared_first(const IndexedTriangle& one, const IndexedTriangle& other, double margin) {
  std::array<std::size_t, 3> of_one = {0, 1, 2};
  std::array<std::size_t, 3> of_other = {0, 1, 2};
  Pair pair;
  pair.margin = margin;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = pair.shared; j < 3; ++j) {
      if (one.vertices[i] == other.vertices[of_other[j]]) {
        // The corners swapped out have been compared already or are not shared.
        std::swap(of_one[i], of_one[pair.shared]);
        std::swap(of_other[j], of_other[pair.shared]);
        ++pair.shared;
        break;
      }
    }
  }
  const Vec3 origin = one.corners[of_one[0]];
  for (std::size_t i = 0; i < 3; ++i) {
    pair.corners[0][i] = one.corners[of_one[i]] - origin;
    pair.corners[1][i] = other.corners[of_other[i]] - origin;
  }
  return pair;
}

/// Interval of the projections of a triangle's unshared corners on a direction.
struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
};

Extent extent_along(const Pair& pair, std::size_t which, const Vec3& direction) {
  Extent extent;
  for (std::size_t i = pair.shared; i < 3; ++i) {
    const double along = direction.dot(pair.corners[which][i]);
    extent.low = std::min(extent.low, along);
    extent.high = std::max(extent.high, along);
  }
  return extent;
}

/// `direction` is perpendicular to what is shared: the edge, or any direction for a vertex.
bool apart_along(const Pair& pair, const Vec3& direction) {
  const Extent one = extent_along(pair, 0, direction);
  const Extent other = extent_along(pair, 1, direction);
  const double margin = pair.margin * direction.norm();
  if (!(margin > 0)) {
    return false;
  }
  if (pair.shared == 0) {
    return other.low > one.high + margin || one.low > other.high + margin;
  }
  // The plane goes through the shared corners; one triangle may touch it along an edge.
  const double touch = touch_fraction * margin;
  return (one.high <= touch && other.low > margin) || (one.low >= -touch && other.high < -margin) ||
         (other.high <= touch && one.low > margin) || (other.low >= -touch && one.high < -margin);
}

/// The triangle's own plane and the planes perpendicular to it through its edges.
bool apart_by_planes_of(const Pair& pair, std::size_t which) {
  const auto& [a, b, c] = pair.corners[which];
  const Vec3 normal = (b - a).cross(c - a);
  if (apart_along(pair, normal)) {
    return true;
  }
  // Only edges that contain all shared corners.
  return apart_along(pair, normal.cross(b - a)) || (pair.shared < 2 && apart_along(pair, normal.cross(c - a))) ||
         (pair.shared < 1 && apart_along(pair, normal.cross(c - b)));
}

/// For two triangles at one vertex: the plane through it perpendicular to the direction from one triangle to the other.
/// In a flat fan the planes through edges fail, since both triangles may have an edge in each of them.
bool apart_by_middles(const Pair& pair) {
  Vec3 direction = Vec3::Zero();
  for (std::size_t i = 1; i < 3; ++i) {
    direction += pair.corners[1][i].normalized() - pair.corners[0][i].normalized();
  }
  return apart_along(pair, direction);
}

bool apart_by_edges(const Pair& pair) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 edge = pair.corners[0][(i + 1) % 3] - pair.corners[0][i];
    for (std::size_t j = 0; j < 3; ++j) {
      if (apart_along(pair, edge.cross(pair.corners[1][(j + 1) % 3] - pair.corners[1][j]))) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace

bool surely_apart(const IndexedTriangle& one, const IndexedTriangle& other, double margin_m) {
  const Pair pair = shared_first(one, other, margin_m);
  if (pair.shared == 3) {
    return false;
  }
  return apart_by_planes_of(pair, 0) || apart_by_planes_of(pair, 1) || (pair.shared == 0 && apart_by_edges(pair)) ||
         (pair.shared == 1 && apart_by_middles(pair));
}

}  // namespace musclebench

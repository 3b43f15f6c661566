#include "core/measure/muscle_depth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "core/referee/referee_sign.hpp"

namespace musclebench {
namespace {

/// A triangle or a part of one.
struct SurfacePart {
  TriangleCorners corners;
  TriangleInMuscle of;
  double bound_m = 0;  ///< no point of it is deeper
};

constexpr auto shallower = [](const SurfacePart& one, const SurfacePart& other) { return one.bound_m < other.bound_m; };

double reach_from(const Vec3& centre, const TriangleCorners& corners) {
  double squared_m2 = 0;
  for (const Vec3& corner : corners) squared_m2 = std::max(squared_m2, (corner - centre).squaredNorm());
  return std::sqrt(squared_m2);
}

std::array<TriangleCorners, 4> quarters(const TriangleCorners& corners) {
  const auto& [a, b, c] = corners;
  const Vec3 ab = (a + b) / 2, bc = (b + c) / 2, ca = (c + a) / 2;
  return {TriangleCorners{ab, bc, ca}, TriangleCorners{a, ab, ca}, TriangleCorners{ab, b, bc},
          TriangleCorners{ca, bc, c}};
}

}  // namespace

DeepestInMuscle deepest_in_muscles(const MuscleReferee& referee, std::span<const Triangle> triangles,
                                   std::span<const Vec3> positions, std::span<const TriangleInMuscle> candidates,
                                   double tolerance_m, long queries) {
  std::vector<SurfacePart> parts;
  for (const TriangleInMuscle& candidate : candidates) {
    const auto& [a, b, c] = triangles[static_cast<std::size_t>(candidate.triangle)];
    const auto at = [&](int node) { return positions[static_cast<std::size_t>(node)]; };
    parts.push_back({{at(a), at(b), at(c)}, candidate, std::numeric_limits<double>::infinity()});
  }
  DeepestInMuscle best;
  for (long asked = 0; !parts.empty() && parts.front().bound_m > best.depth_m + tolerance_m; ++asked) {
    if (asked >= queries) {
      best.complete = false;
      break;
    }
    std::pop_heap(parts.begin(), parts.end(), shallower);
    const SurfacePart part = parts.back();
    parts.pop_back();
    const Vec3 centre = (part.corners[0] + part.corners[1] + part.corners[2]) / 3;
    const double depth_m = -referee.distance(part.of.other, centre).signed_distance_m;
    if (depth_m > best.depth_m) {
      best.depth_m = depth_m;
      best.triangle = part.of.triangle;
      best.other = part.of.other;
    }
    if (depth_m + reach_from(centre, part.corners) <= best.depth_m + tolerance_m) continue;
    for (const TriangleCorners& quarter : quarters(part.corners)) {
      const double bound_m = std::min(part.bound_m, depth_m + reach_from(centre, quarter));
      if (bound_m <= best.depth_m + tolerance_m) continue;
      parts.push_back({quarter, part.of, bound_m});
      std::push_heap(parts.begin(), parts.end(), shallower);
    }
  }
  best.bound_m = best.complete ? best.depth_m + tolerance_m : parts.front().bound_m;
  return best;
}

std::vector<TriangleInMuscle> triangles_in_muscles(std::span<const Triangle> triangles,
                                                   std::span<const TriangleInMuscle> crossing,
                                                   std::span<const Contact> inside) {
  std::vector<TriangleInMuscle> found(crossing.begin(), crossing.end());
  std::multimap<int, int> muscles_around;  // by node
  for (const Contact& contact : inside) muscles_around.emplace(contact.node, contact.bone);
  for (std::size_t t = 0; t < triangles.size() && !inside.empty(); ++t) {
    for (const int node : triangles[t]) {
      const auto [first, last] = muscles_around.equal_range(node);
      for (auto around = first; around != last; ++around) found.push_back({static_cast<int>(t), around->second});
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace musclebench

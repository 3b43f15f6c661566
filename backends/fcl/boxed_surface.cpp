#include "backends/fcl/boxed_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "backends/fcl/box_tree.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// What a list reaches beyond the closest triangle, in sizes of a triangle: less is used up sooner, more is longer to
/// make.
constexpr double list_reach = 1.5;

/// What a clearance is at least of the distance: less is found sooner, more is used up later.
constexpr double clearance_share = 0.8;

constexpr std::size_t width = ClosestOnTriangles::width;

/// Up to a whole multiple of eight, by its last one.
void pad(std::vector<std::int32_t>& triangles) {
  if (!triangles.empty()) {
    triangles.resize((triangles.size() + width - 1) / width * width, triangles.back());
  }
}

}  // namespace

BoxedSurface::BoxedSurface(const RepairedMesh& surface)
    : SignedFclSurface(surface),
      m_tree(std::make_shared<BoxTree>(surface.mesh.vertices, surface.mesh.triangles)),
      m_triangle_size_m(mean_triangle_size_m(surface.mesh)) {}

ClosestPoint BoxedSurface::closest(const Vec3& point, int triangle) const {
  triangle = std::max(triangle, 0);
  ClosestOnTriangle best = closest_on(point, triangle);
  m_tree->search(point, reach_m(std::sqrt(best.squared_distance_m2)), [&](int candidate) {
    const ClosestOnTriangle found = closest_on(point, candidate);
    if (found.squared_distance_m2 < best.squared_distance_m2 ||
        (found.squared_distance_m2 == best.squared_distance_m2 && candidate < triangle)) {
      best = found;
      triangle = candidate;
    }
    return reach_m(std::sqrt(best.squared_distance_m2));
  });
  return {best.point, std::sqrt(best.squared_distance_m2), triangle, best.feature};
}

/// Of an open surface the side changes in empty space, too: across a hole, and where its box ends.
Clearance BoxedSurface::clearance(const Vec3& point, int triangle) const {
  if (!sides().closed()) {
    return {0, triangle};
  }
  double best_m = distance_m(point, triangle);
  m_tree->search(point, clearance_share * best_m, [&](int candidate) {
    const double found_m = distance_m(point, candidate);
    if (found_m < best_m) {
      best_m = found_m;
      triangle = candidate;
    }
    return clearance_share * best_m;
  });
  return {std::max((1 - rounding_share) * clearance_share * best_m - rounding_m(), 0.0), triangle};
}

PointSide BoxedSurface::side(const Vec3& point, const ClosestPoint& closest) const {
  if (contains(point, closest)) {
    return {.inside = true};
  }
  const bool known = sides().closed() && closest.distance_m > touching_m();
  return {.inside = false, .clearance_m = known ? (1 - rounding_share) * closest.distance_m : 0};
}

void BoxedSurface::list_candidates(const Vec3& point, double bound_m, NearTriangles& list) const {
  const double radius_m = bound_m + list_reach * m_triangle_size_m;
  std::vector<std::int32_t> met;
  met.reserve(256);
  m_tree->list_met(point, radius_m, met);
  const std::size_t count = met.size();
  pad(met);
  std::vector<std::pair<double, std::int32_t>> by_distance;
  by_distance.reserve(count);
  for (std::size_t first = 0; first < count; first += width) {
    static constexpr std::array<std::int32_t, width> the_point = {};
    ClosestOnTriangles found;
    closest_on_triangles(&point, sides().tree().corners(), the_point, {&met[first], width}, {&found, 1});
    for (std::size_t i = first; i < std::min(first + width, count); ++i) {
      const double distance_m =
          sides().tree().is_sliver(met[i]) ? 0.0 : std::sqrt(found.squared_distance_m2[i - first]);
      if (distance_m < radius_m) {
        by_distance.emplace_back(distance_m, met[i]);
      }
    }
  }
  list.place = point;
  list.count = std::min(by_distance.size(), NearTriangles::capacity);
  const bool all = list.count == by_distance.size();
  const auto first_left_out = by_distance.begin() + static_cast<std::ptrdiff_t>(list.count);
  std::partial_sort(by_distance.begin(), all ? first_left_out : first_left_out + 1, by_distance.end());
  list.complete_m = (1 - rounding_share) * (all ? radius_m : first_left_out->first) - rounding_m();
  for (std::size_t i = 0; i < list.count; ++i) {
    list.distance_m[i] = std::nextafter(static_cast<float>(std::max(by_distance[i].first - rounding_m(), 0.0)), 0.0F);
    list.triangles[i] = by_distance[i].second;
  }
  for (std::size_t i = list.count; i % width != 0; ++i) {
    list.triangles[i] = list.triangles[i - 1];
  }
}

void BoxedSurface::begin_candidate_search(const Vec3& point, const NearTriangles& list, CandidateSearch& search) const {
  search.point = point;
  for (std::size_t i = 0; i < width; ++i) {
    __builtin_prefetch(sides().tree().corners() + list.triangles[i]);
  }
}

ClosestCandidate BoxedSurface::finish_candidate_search(const NearTriangles& list, double /*enough_m*/,
                                                       const CandidateSearch& search) const {
  const Vec3& point = search.point;
  constexpr double slack = 1e-12;  // above the rounding of roots
  const double moved_m = (point - list.place).norm() * (1 + slack);
  double best_m = std::numeric_limits<double>::infinity();
  ClosestOfMany closest(point, sides().tree().corners());
  for (std::size_t i = 0; i < list.count && !(static_cast<double>(list.distance_m[i]) - moved_m > best_m); i += width) {
    closest.take(&list.triangles[i]);
    best_m = std::sqrt(closest.squared_distance_m2()) * (1 + slack);
  }
  return {closest.answer(), best_m < list.complete_m - moved_m};
}

std::size_t BoxedSurface::bytes() const { return sizeof(*this) + m_tree->bytes() + sides().bytes(); }

}  // namespace musclebench

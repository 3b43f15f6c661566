#pragma once

#include <concepts>
#include <cstddef>

#include "core/bvh/triangle_bvh.hpp"

namespace musclebench {

/// Which side of a surface a point is on.
struct PointSide {
  bool inside = false;
  double clearance_m = 0;  ///< of a point outside: radius of a sphere about it that holds nothing inside; 0: unknown
};

/// What CachedPointQuery needs to know about the surface of one bone. Points are in the bone's rest frame, lengths in
/// metres, triangles are indices. Everything is const and safe from several threads; a `CandidateSearch` belongs to one
/// query at a time. `ClosestPoint::point` may be in any frame: it is only handed back.
///
/// - `is_outside(point, clearance_m)`: a cheap test without a search. True only for a point that is outside for
///   certain, with `clearance_m` as in PointSide; true with 0 for a point that is not finite.
/// - `closest(point, triangle)`: the closest point of the surface; of several triangles at the same distance the one
///   with the smallest index. A `triangle` near the point makes the search faster and changes no bit of the answer; -1:
///   none is known.
/// - `clearance(point, triangle)`: a lower bound of the distance, cheaper than `closest`.
/// - `distance_m(point, triangle)`: the distance of one triangle.
/// - `side(point, closest)`: the side of a point, given its closest point.
/// - `outward(point, closest)`: unit normal out of the surface at the closest point of a point inside.
/// - `touching_m()`: no point closer to the surface than this counts as inside.
/// - `bytes()`: of what it holds.
/// - `near_m()`: candidate lists pay off for points closer to the surface than this.
///
/// A `CandidateList` holds the triangles near one location (a Verlet list): `empty()` after `clear()`.
///
/// - `list_candidates(point, bound_m, list)`: lists what is near `point`, whose distance is at most `bound_m`.
/// - `begin_candidate_search(point, list, search)`, then `finish_candidate_search(list, enough_m, search)`: the closest
///   point among the candidates, and whether it is certainly the closest of all; or only a lower bound of the distance,
///   where that exceeds `enough_m`. In two parts, so that the memory accesses of several queries overlap.
/// - `prefetch(point, list)`: begins to load what a query at `point` needs first: the candidates of `list`, or what
///   `is_outside` reads where the list is empty.
template <typename Surface>
concept QuerySurface = requires(const Surface& surface, const Vec3& point, const ClosestPoint& closest, int triangle,
                                double length_m, double& clearance_m, typename Surface::CandidateList& list,
                                typename Surface::CandidateSearch& search) {
  { surface.is_outside(point, clearance_m) } -> std::same_as<bool>;
  { surface.closest(point, triangle) } -> std::same_as<ClosestPoint>;
  { surface.clearance(point, triangle) } -> std::same_as<Clearance>;
  { surface.distance_m(point, triangle) } -> std::same_as<double>;
  { surface.side(point, closest) } -> std::same_as<PointSide>;
  { surface.outward(point, closest) } -> std::convertible_to<Vec3>;
  { surface.touching_m() } -> std::same_as<double>;
  { surface.near_m() } -> std::same_as<double>;
  { surface.bytes() } -> std::same_as<std::size_t>;
  { list.empty() } -> std::same_as<bool>;
  list.clear();
  surface.list_candidates(point, length_m, list);
  surface.begin_candidate_search(point, list, search);
  { surface.finish_candidate_search(list, length_m, search) } -> std::same_as<ClosestCandidate>;
  surface.prefetch(point, list);
};

}  // namespace musclebench

#pragma once

#include <concepts>
#include <cstddef>

#include "core/bvh/triangle_bvh.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// The side of a surface on which a point is.
struct PointSide {
  bool inside = false;
  double clearance_m = 0;  ///< for a point outside: radius of a sphere around it that is all outside; 0: unknown
};

/// The operations that CachedPointQuery needs from the surface of one bone. Points are in the bone's rest frame, in
/// metres. Triangles are indices. All operations are const and safe from several threads. One query at a time uses a
/// `CandidateSearch`. `ClosestPoint::point` may be in any frame, because it is only passed back.
///
/// - `is_outside(point, clearance_m)`: a cheap test without a search. True only if the point is certainly outside. It
///   then sets `clearance_m` as in PointSide. For a point that is not finite it returns true and sets 0.
/// - `closest(point, triangle)`: the closest point of the surface. Of several triangles at the same distance it takes
/// the
///   smallest index. `triangle` is one near the point, or -1. It makes the search faster and changes no bit.
/// - `clearance(point, triangle)`: a lower bound of the distance, cheaper than `closest`.
/// - `distance_m(point, triangle)`: the distance to one triangle.
/// - `side(point, closest)`: the side of a point. `closest` is its closest point.
/// - `outward(point, closest)`: the unit normal out of the surface at the closest point of a point inside.
/// - `answer_bound()`: see BoneStructure.
/// - `touching_m()`: a point closer to the surface than this never counts as inside.
/// - `bytes()`: memory of the surface.
/// - `near_m()`: candidate lists pay off for points closer to the surface than this.
///
/// A `CandidateList` holds the triangles near one location (a Verlet list). After `clear()` it is `empty()`.
///
/// - `list_candidates(point, bound_m, list)`: lists the triangles near `point`. Its distance is at most `bound_m`.
/// - `begin_candidate_search(point, list, search)`, then `finish_candidate_search(list, enough_m, search)`: finds the
///   closest point among the candidates, and whether it is certainly the closest of all. If the distance certainly
///   exceeds `enough_m`, it may return only a lower bound. The two parts let the memory accesses of queries overlap.
/// - `prefetch(point, list)`: starts loading the memory that a query at `point` reads first. That is the candidates of
///   `list`, or the memory of `is_outside` if the list is empty.
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
  { surface.answer_bound() } -> std::same_as<AnswerBound>;
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

#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/bvh/triangle_bvh.hpp"
#include "core/contact/bone.hpp"

namespace musclebench {

/// Where a point is to the surface of a bone. Lengths are in metres, in the bone's rest frame.
struct SurfaceAnswer {
  double signed_distance_m = 0;   ///< negative inside
  Vec3 gradient = Vec3::UnitZ();  ///< of the signed distance: unit, outwards
  Vec3 closest_m = Vec3::Zero();  ///< the closest point of the surface
  int near = -1;                  ///< what makes the next query near here faster, such as a triangle
};

/// What contact of a muscle's faces and edges asks about the surface of one bone. Unlike contact of nodes it needs
/// distances outside, too, and where edges leave the bone. Derive from it if your backend can tell a signed distance
/// and its gradient on both sides of the surface, and name it in `BackendEntry::make_surface_queries`.
///
/// Within the bone's box distances err by no more than the backend's declared bound (AnswerBound), farther outside by
/// no more than half of themselves. Points are finite, in the bone's rest frame, in metres. `near` is -1 or what an
/// answer near the point told; it must change no bit. Queries are safe from several threads.
class SurfaceQueries {
 public:
  SurfaceQueries() = default;
  SurfaceQueries(const SurfaceQueries&) = delete;
  SurfaceQueries& operator=(const SurfaceQueries&) = delete;
  virtual ~SurfaceQueries() = default;

  [[nodiscard]] virtual SurfaceAnswer locate(const Vec3& point, int near) const = 0;
  /// The same bits, where the answer `last` at `last_point` is known: a side need not be asked for again if the surface
  /// was farther away than the points are apart.
  [[nodiscard]] virtual SurfaceAnswer locate_from(const Vec3& point, const Vec3& /*last_point*/,
                                                  const SurfaceAnswer& last) const {
    return locate(point, last.near);
  }

  /// A lower bound of the distance, cheaper than `locate` where that is possible. `triangle` is what to pass as `near`
  /// next, if the bound is positive.
  [[nodiscard]] virtual Clearance clearance(const Vec3& point, int near) const = 0;

  /// How far a point inside goes along `direction` (unit) until it leaves the bone, in metres. Nothing if it does not
  /// leave within `length_m`, or if it first enters a part of the bone that overlaps the one it is in. By default
  /// steps of the distance that is free (sphere tracing), to a millionth of `length_m`. `scratch` keeps its memory from
  /// one query to the next.
  [[nodiscard]] virtual std::optional<double> way_out_m(const Vec3& from, const Vec3& direction, double length_m,
                                                        int near, std::vector<PathCrossing>& scratch) const;

  /// Memory that only these queries need. What all users of the bone share is not counted.
  [[nodiscard]] virtual std::size_t bytes() const = 0;
};

/// Builds the queries over a bone, which outlives them. May use `threads` threads.
using MakeSurfaceQueries = std::function<std::shared_ptr<const SurfaceQueries>(const Bone& bone, int threads)>;

/// The exact ones, over the surface that all users of the bone share.
std::shared_ptr<const SurfaceQueries> exact_surface_queries(const Bone& bone);

}  // namespace musclebench

#pragma once

#include <cmath>
#include <cstddef>
#include <memory>

#include "core/bvh/triangle_bvh_search.hpp"
#include "core/clearance/query_surface.hpp"
#include "core/contact/bone.hpp"
#include "core/signed_distance/clearance_grid.hpp"

namespace musclebench {

/// Exact closest points and sides for the surface of one bone in rest pose: a QuerySurface, where its operations are
/// described. A bone far from the origin is kept relative to the middle of its bounding box, so that it loses no
/// digits; `closest.point` is in that frame, every other point in the bone's rest frame. Queries are const and safe
/// from several threads.
class ExactSurface {
 public:
  using CandidateList = CandidateLeaves;
  using CandidateSearch = TriangleBvh::Search;

  /// Of a bone with triangles, whose shared signed distance it keeps. `threads` take part in the construction.
  ExactSurface(const Bone& bone, int threads);

  [[nodiscard]] bool is_outside(const Vec3& point, double& clearance_m) const;
  [[nodiscard]] ClosestPoint closest(const Vec3& point, int triangle) const;
  [[nodiscard]] Clearance clearance(const Vec3& point, int triangle) const;
  [[nodiscard]] double distance_m(const Vec3& point, int triangle) const {
    return std::sqrt(m_surface->tree().closest_on(point - m_origin_m, triangle).squared_distance_m2);
  }
  [[nodiscard]] PointSide side(const Vec3& point, const ClosestPoint& closest) const;
  [[nodiscard]] Vec3 outward(const Vec3& point, const ClosestPoint& closest) const;
  [[nodiscard]] AnswerBound answer_bound() const { return {m_touching_m, 0}; }
  [[nodiscard]] double touching_m() const { return m_touching_m; }
  [[nodiscard]] double near_m() const { return m_near_m; }

  void list_candidates(const Vec3& point, double bound_m, CandidateLeaves& list) const;
  void prefetch(const Vec3& point, const CandidateLeaves& list) const {
    if (!list.empty()) {
      m_surface->tree().prefetch_leaves(list);
    } else if (is_searchable(point)) {
      m_clearances.prefetch(point - m_origin_m);
    }
  }
  void begin_candidate_search(const Vec3& point, const CandidateLeaves& list, CandidateSearch& search) const {
    m_surface->tree().begin_candidate_search(point - m_origin_m, list, search);
    for (std::size_t i = 0; i < search.count; ++i) {
      m_surface->prefetch_sign(search.triangle[i]);
    }
  }
  [[nodiscard]] ClosestCandidate finish_candidate_search(const CandidateLeaves& list, double enough_m,
                                                         CandidateSearch& search) const {
    return m_surface->tree().finish_candidate_search(search, list, enough_m);
  }

  /// Signed distance of a finite point in metres, negative inside.
  [[nodiscard]] double signed_distance_m(const Vec3& point) const {
    return m_surface->locate(point - m_origin_m).signed_distance_m();
  }

  /// Whether the directed edges of all triangles cancel.
  [[nodiscard]] bool closed() const { return m_surface->closed(); }

  [[nodiscard]] std::size_t bytes() const { return sizeof(ExactSurface) + m_surface->bytes() + m_clearances.bytes(); }

 private:
  /// The squares of larger coordinates overflow.
  static constexpr double farthest_m = 1e100;
  static bool is_searchable(const Vec3& point) { return (point.array().abs() < farthest_m).all(); }

  ExactSurface(const Bone& bone, const Eigen::AlignedBox3d& box, int threads);

  Vec3 m_origin_m;            ///< of the frame that the surface is kept in
  Eigen::AlignedBox3d m_box;  ///< of the surface in that frame
  double m_near_m;
  double m_touching_m;
  std::shared_ptr<const SignedSurface> m_surface;
  ClearanceGrid m_clearances;  ///< empty for a surface that is not closed
};

}  // namespace musclebench

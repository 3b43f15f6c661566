#pragma once

#include <cmath>
#include <cstddef>

#include "core/signed_distance/clearance_grid.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// The exact surface of one bone in rest pose, held about the middle of its box, so that a bone far from the origin
/// loses no digits. All points, also those of answers, are points of the bone's rest frame. Safe from several threads.
/// A `Surface` of CachedPointQuery, which says what its members are for.
class ExactSurface {
 public:
  /// Copies what it needs. The surface has triangles. `threads`: for making it.
  ExactSurface(const RepairedMesh& surface, int threads);

  [[nodiscard]] bool is_outside(const Vec3& point, double& clearance_m) const;
  void fetch_clearance(const Vec3& point) const {
    if (is_searchable(point)) {
      m_clearances.fetch(point - m_centre_m);
    }
  }
  [[nodiscard]] ClosestPoint closest(const Vec3& point) const;
  [[nodiscard]] ClosestPoint closest_from(const Vec3& point, int triangle) const;
  [[nodiscard]] double distance_m(const Vec3& point, int triangle) const {
    return std::sqrt(m_surface.tree().closest_on(point - m_centre_m, triangle).squared_distance_m2);
  }
  using CandidateList = CandidateLeaves;
  void list_candidates(const Vec3& point, double bound_m, CandidateLeaves& list) const;
  using CandidateSearch = TriangleBvh::Search;
  void fetch(const CandidateLeaves& list) const { m_surface.tree().fetch(list); }
  void begin_candidate_search(const Vec3& point, const CandidateLeaves& list, CandidateSearch& search) const {
    m_surface.tree().begin_candidate_search(point - m_centre_m, list, search);
    for (std::size_t i = 0; i < search.count; ++i) {
      m_surface.fetch_sign(search.triangle[i]);
    }
  }
  [[nodiscard]] ClosestCandidate finish_candidate_search(const Vec3& /*point*/, const CandidateLeaves& list,
                                                         double enough_m, CandidateSearch& search) const {
    return m_surface.tree().finish_candidate_search(search, list, enough_m);
  }
  [[nodiscard]] Clearance clearance_from(const Vec3& point, int triangle) const;
  [[nodiscard]] bool contains(const Vec3& point, const ClosestPoint& closest) const;
  [[nodiscard]] Vec3 outward(const Vec3& point, const ClosestPoint& closest) const;
  /// Across a hole the side changes without a surface.
  [[nodiscard]] double free_m(const ClosestPoint& closest) const {
    return closed() && closest.distance_m > m_touching_m ? closest.distance_m : 0;
  }
  [[nodiscard]] double near_m() const { return m_near_m; }
  [[nodiscard]] double touching_m() const { return m_touching_m; }

  /// Signed distance of a finite point, in metres; negative inside.
  [[nodiscard]] double signed_distance_m(const Vec3& point) const {
    return m_surface.locate(point - m_centre_m).signed_distance_m();
  }

  /// Whether the directed edges of all triangles cancel.
  [[nodiscard]] bool closed() const { return m_surface.closed(); }

  [[nodiscard]] std::size_t bytes() const { return sizeof(ExactSurface) + m_surface.bytes() + m_clearances.bytes(); }

 private:
  /// Beyond this a square is not a number any more.
  static constexpr double farthest_m = 1e100;
  static bool is_searchable(const Vec3& point) { return (point.array().abs() < farthest_m).all(); }

  ExactSurface(const RepairedMesh& surface, const Eigen::AlignedBox3d& box, int threads);

  Vec3 m_centre_m;
  Vec3 m_half_extents_m;
  double m_near_m;
  double m_touching_m;
  SignedSurface m_surface;
  ClearanceGrid m_clearances;  ///< of a closed surface
};

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "backends/fcl/near_triangles.hpp"
#include "backends/fcl/signed_fcl_surface.hpp"
#include "core/clearance/query_surface.hpp"

namespace musclebench {

class BoxTree;

/// One bone as the clearance cache needs it: FCL's tree of boxes says which triangles are near a point, and each of
/// them is measured here, eight side by side where they come together. So a search answers what brute force does, to
/// the bit, and what it starts from changes its time only. A QuerySurface, where the operations are described.
class BoxedSurface : public SignedFclSurface {
 public:
  explicit BoxedSurface(const RepairedMesh& surface);

  [[nodiscard]] ClosestPoint closest(const Vec3& point, int triangle) const;
  [[nodiscard]] Clearance clearance(const Vec3& point, int triangle) const;
  using CandidateList = NearTriangles;
  void list_candidates(const Vec3& point, double bound_m, NearTriangles& list) const;
  struct CandidateSearch {
    Vec3 point;
  };
  void prefetch(const Vec3& /*point*/, const NearTriangles& /*list*/) const {}
  void begin_candidate_search(const Vec3& point, const NearTriangles& list, CandidateSearch& search) const;
  [[nodiscard]] ClosestCandidate finish_candidate_search(const NearTriangles& list, double enough_m,
                                                         const CandidateSearch& search) const;
  [[nodiscard]] PointSide side(const Vec3& point, const ClosestPoint& closest) const;
  [[nodiscard]] double near_m() const { return m_triangle_size_m; }

  [[nodiscard]] std::size_t bytes() const;

 private:
  std::shared_ptr<const BoxTree> m_tree;
  double m_triangle_size_m;
};

}  // namespace musclebench

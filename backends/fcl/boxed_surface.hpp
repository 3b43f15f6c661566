#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "backends/fcl/near_triangles.hpp"
#include "backends/fcl/sided_surface.hpp"
#include "core/bvh/triangle_tree.hpp"

namespace musclebench {

class BoxTree;

/// One bone as motion budgets want it: FCL's tree of boxes says which triangles are near a point, and each of them is
/// measured here, eight side by side where they come together. So a search answers what brute force does, to the bit,
/// and what it starts from changes its time only. A `Surface` of NodeDetection, which says what its members are for.
class BoxedSurface : public SidedSurface {
 public:
  explicit BoxedSurface(const RepairedMesh& surface);

  [[nodiscard]] ClosestPoint closest(const Vec3& point) const;
  [[nodiscard]] ClosestPoint closest_from(const Vec3& point, int triangle) const;
  [[nodiscard]] Clearance clearance_from(const Vec3& point, int triangle) const;
  using NearList = NearTriangles;
  void list_near(const Vec3& point, double bound_m, NearTriangles& list) const;
  struct ListSearch {};
  void fetch(const NearTriangles& /*list*/) const {}
  void fetch_clearance(const Vec3& /*point*/) const {}
  void start_listed(const Vec3& point, const NearTriangles& list, ListSearch& search) const;
  [[nodiscard]] ListedClosest finish_listed(const Vec3& point, const NearTriangles& list, double enough_m,
                                            const ListSearch& search) const;
  [[nodiscard]] double free_m(const ClosestPoint& closest) const;
  [[nodiscard]] double near_m() const { return m_triangle_size_m; }

  [[nodiscard]] std::size_t bytes() const;

 private:
  std::shared_ptr<const BoxTree> m_tree;
  double m_triangle_size_m;
};

}  // namespace musclebench

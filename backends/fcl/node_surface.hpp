// Knows FCL's types: for the .cpp files of this folder only.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <fcl/geometry/collision_geometry.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/gjk_solver_type.h>

#include "backends/fcl/fcl_options.hpp"
#include "backends/fcl/near_triangles.hpp"
#include "core/geometry/signed_surface.hpp"

namespace musclebench {

/// One bone's FCL model, asked about points in the bone's rest frame; from several threads at once. FCL says which
/// triangles are near; the closest point on them is then computed here, so that it does not depend on what was asked of
/// FCL to find them. FCL takes a surface for hollow; which side a point is on is SignedSurface's answer. A `Surface` of
/// NodeDetection, which says what its members are for.
class NodeSurface {
 public:
  /// Keeps a reference to `surface`.
  NodeSurface(const FclOptions& options, const RepairedMesh& surface, std::shared_ptr<fcl::CollisionGeometryd> model);

  [[nodiscard]] bool is_outside(const Vec3& point, double& clearance_m) const;
  [[nodiscard]] ClosestPoint closest(const Vec3& point) const;
  [[nodiscard]] ClosestPoint closest_from(const Vec3& point, int triangle) const;
  [[nodiscard]] ClosestOnTriangle closest_on(const Vec3& point, int triangle) const;
  [[nodiscard]] double distance_m(const Vec3& point, int triangle) const;
  using NearList = NearTriangles;
  void list_near(const Vec3& point, double bound_m, NearTriangles& list) const;
  /// A list has it all: there is nothing to start.
  struct ListSearch {};
  static void start_listed(const Vec3& /*point*/, const NearTriangles& /*list*/, ListSearch& /*search*/) {}
  [[nodiscard]] ListedClosest finish_listed(const Vec3& point, const NearTriangles& list, double enough_m,
                                            const ListSearch& search) const;
  [[nodiscard]] static Clearance clearance_from(const Vec3& /*point*/, int triangle) { return {0, triangle}; }
  [[nodiscard]] bool contains(const Vec3& point, const ClosestPoint& closest) const;
  [[nodiscard]] Vec3 outward(const Vec3& point, const ClosestPoint& closest) const;
  [[nodiscard]] ClosestPoint settled(const Vec3& point, const ClosestPoint& closest) const;
  [[nodiscard]] double free_m(const Vec3& point, const ClosestPoint& closest, bool is_settled) const;
  [[nodiscard]] double near_m() const { return m_triangle_size_m; }

  /// The closest triangle that a sphere of `node_radius_m` about `point` meets; its index is -1 where it meets none.
  [[nodiscard]] ClosestPoint closest_met(const Vec3& point) const;

  /// A point closer to the surface than this is not contained: which side it is on is rounding.
  [[nodiscard]] double touching_m() const { return m_touching_m; }
  /// Without the model.
  [[nodiscard]] std::size_t bytes() const { return sizeof(*this) + m_sides.bytes(); }

 private:
  /// The nearest triangle by FCL's distance; `triangle`, one at `bound_m`, where it finds none that is nearer.
  [[nodiscard]] ClosestPoint closest_by_distance(const Vec3& point, double bound_m, int triangle) const;
  /// The triangles that a sphere meets, in any order.
  void meet(const Vec3& point, double radius_m, std::vector<int>& triangles) const;
  [[nodiscard]] ClosestPoint closest_of(const Vec3& point, std::span<const int> triangles) const;
  /// The closest one, given one and its distance.
  [[nodiscard]] ClosestPoint closest_within(const Vec3& point, double distance_m, int triangle) const;

  const TriangleMesh& m_mesh;
  SignedSurface m_sides;
  std::shared_ptr<fcl::CollisionGeometryd> m_model;
  fcl::GJKSolverType m_solver;
  Eigen::AlignedBox3d m_box;
  std::vector<bool> m_needles;  ///< by triangle
  double m_touching_m;
  double m_node_radius_m;
  double m_triangle_size_m;
};

}  // namespace musclebench

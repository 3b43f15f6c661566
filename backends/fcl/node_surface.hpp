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
#include "backends/fcl/signed_fcl_surface.hpp"

namespace musclebench {

/// One bone's FCL model, asked about points in the bone's rest frame by FCL's calls; from several threads at once. FCL
/// says which triangles are near; the closest point on them is then computed here, so that it does not depend on what
/// was asked of FCL to find them.
class NodeSurface : public SignedFclSurface {
 public:
  NodeSurface(const FclOptions& options, const RepairedMesh& surface, std::shared_ptr<fcl::CollisionGeometryd> model);

  /// The closest triangle by FCL's distance.
  [[nodiscard]] ClosestPoint closest(const Vec3& point) const;

  /// Of all triangles at the smallest squared distance the one with the smallest index, given what `closest` found.
  [[nodiscard]] ClosestPoint settled(const Vec3& point, const ClosestPoint& closest) const;

  /// The closest triangle that a sphere of `node_radius_m` about `point` meets; its index is -1 where it meets none.
  [[nodiscard]] ClosestPoint closest_met(const Vec3& point) const;

  /// Without the model.
  [[nodiscard]] std::size_t bytes() const { return sizeof(*this) + sides().bytes(); }

 private:
  /// The triangles that a sphere meets, in any order.
  void meet(const Vec3& point, double radius_m, std::vector<int>& triangles) const;
  [[nodiscard]] ClosestPoint closest_of(const Vec3& point, std::span<const int> triangles) const;

  std::shared_ptr<fcl::CollisionGeometryd> m_model;
  fcl::GJKSolverType m_solver;
  double m_node_radius_m;
};

}  // namespace musclebench

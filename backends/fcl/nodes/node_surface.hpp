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
#include "core/contact/bone.hpp"

namespace musclebench {

/// One bone's FCL model, asked about points in the bone's rest frame by FCL's calls; from several threads at once. FCL
/// says which triangles are near; the closest point on them is then computed here, so that it does not depend on what
/// was asked of FCL to find them. FCL takes a surface for hollow: which side a point is on is SignedSurface's answer.
class NodeSurface {
 public:
  /// Throws InputError for an unknown bounding volume.
  NodeSurface(const FclOptions& options, const Bone& bone);

  /// Of the bone, by more than `reach_m`; so is what is not finite.
  [[nodiscard]] bool is_outside_box(const Vec3& point, double reach_m) const;

  /// The closest triangle by FCL's distance.
  [[nodiscard]] ClosestPoint closest(const Vec3& point) const;

  /// Of all triangles at the smallest squared distance the one with the smallest index, given what `closest` found.
  [[nodiscard]] ClosestPoint settled(const Vec3& point, const ClosestPoint& closest) const;

  /// The closest triangle that a sphere of `node_radius_m` about `point` meets; its index is -1 where it meets none.
  [[nodiscard]] ClosestPoint closest_met(const Vec3& point) const;

  /// Whether the bone contains a point with that closest point; not where the two are within `touching_m`.
  [[nodiscard]] bool contains(const Vec3& point, const ClosestPoint& closest) const;
  /// Unit, for a point that the bone contains.
  [[nodiscard]] static Vec3 outward(const Vec3& point, const ClosestPoint& closest);

  /// A point closer to the surface than this is not contained: which side it is on is rounding.
  [[nodiscard]] double touching_m() const { return m_touching_m; }

  /// What distances of FCL and those that are measured here differ by.
  [[nodiscard]] double rounding_m() const { return m_rounding_m; }

  [[nodiscard]] std::size_t bytes() const { return sizeof(*this) + m_sides->bytes() + m_model_bytes; }

 private:
  [[nodiscard]] ClosestOnTriangle closest_on(const Vec3& point, int triangle) const {
    return m_sides->tree().closest_on(point, triangle);
  }
  /// The triangles that a sphere meets, in any order.
  void meet(const Vec3& point, double radius_m, std::vector<int>& triangles) const;
  [[nodiscard]] ClosestPoint closest_of(const Vec3& point, std::span<const int> triangles) const;

  std::shared_ptr<const SignedSurface> m_sides;
  Eigen::AlignedBox3d m_box;
  double m_touching_m;
  double m_rounding_m;
  std::shared_ptr<fcl::CollisionGeometryd> m_model;
  std::size_t m_model_bytes = 0;
  fcl::GJKSolverType m_solver;
  double m_node_radius_m;
};

}  // namespace musclebench

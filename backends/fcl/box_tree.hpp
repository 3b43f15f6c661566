// Knows FCL's types: for the .cpp files of this folder only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/detail/traversal/collision/bvh_shape_collision_traversal_node.h>
#include <fcl/narrowphase/detail/traversal/distance/bvh_shape_distance_traversal_node.h>
#include <fcl/narrowphase/detail/traversal/traversal_recurse.h>

#include "backends/fcl/fcl_model.hpp"

namespace musclebench {

/// FCL's tree of axis-parallel boxes over triangles at rest: its model, its recursions, its tests of boxes, without its
/// calls: `fcl::collide` copies such a model every time, and `fcl::distance` does not know it. Which triangles are near
/// is FCL's answer; how near they are is measured by whoever asks. From several threads at once.
class BoxTree {
 public:
  BoxTree(std::span<const Vec3> vertices, std::span<const Triangle> triangles)
      : m_model(make_fcl_model<fcl::AABBd>(vertices, triangles)) {}

  /// The triangles whose boxes meet that of the sphere, in any order, into `triangles`, which is overwritten.
  void list_met(const Vec3& point, double radius_m, std::vector<std::int32_t>& triangles) const {
    triangles.clear();
    Meeting meeting(*m_model, point, radius_m, triangles);
    fcl::detail::collisionRecurse(&meeting, 0, 0, nullptr);
  }

  /// Calls `double measure(triangle)` for triangles, the nearer first, whose boxes are closer than what it answered
  /// last (at the start: `bound_m`).
  template <typename Measure>
  void search(const Vec3& point, double bound_m, const Measure& measure) const {
    Nearing<Measure> nearing(*m_model, point, bound_m, measure);
    fcl::detail::distanceRecurse(&nearing, 0, 0, nullptr);
  }

  [[nodiscard]] std::size_t bytes() const { return model_bytes(*m_model); }

 private:
  using Model = FclModel<fcl::AABBd>;

  class Meeting final : public fcl::detail::BVHShapeCollisionTraversalNode<fcl::AABBd, fcl::Sphered> {
   public:
    Meeting(const Model& model, const Vec3& point, double radius_m, std::vector<std::int32_t>& triangles)
        : m_triangles(triangles) {
      model1 = &model;
      const Vec3 reach = Vec3::Constant(radius_m);
      model2_bv = fcl::AABBd(point - reach, point + reach);
    }
    void leafTesting(int node, int /*sphere*/) const override {
      m_triangles.push_back(model1->getBV(node).primitiveId());
    }
    [[nodiscard]] bool canStop() const override { return false; }

   private:
    std::vector<std::int32_t>& m_triangles;
  };

  template <typename Measure>
  class Nearing final : public fcl::detail::BVHShapeDistanceTraversalNode<fcl::AABBd, fcl::Sphered> {
   public:
    Nearing(const Model& model, const Vec3& point, double bound_m, const Measure& measure)
        : m_measure(measure), m_bound_m(bound_m) {
      model1 = &model;
      model2_bv = fcl::AABBd(point);
    }
    void leafTesting(int node, int /*point*/) const override {
      m_bound_m = m_measure(model1->getBV(node).primitiveId());
    }
    [[nodiscard]] bool canStop(double distance_m) const override { return distance_m > m_bound_m; }

   private:
    const Measure& m_measure;
    mutable double m_bound_m;  // leafTesting is const
  };

  std::shared_ptr<const Model> m_model;
};

}  // namespace musclebench

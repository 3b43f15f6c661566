#include "backends/fcl/nodes/node_backend.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include "backends/fcl/fcl_model.hpp"
#include "core/clearance/located_nodes.hpp"
#include "core/clearance/point_backend.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

constexpr std::size_t all_contacts = std::numeric_limits<std::size_t>::max();
/// Distances that FCL measures and those that are measured here differ by this share of them, besides the rounding of
/// coordinates.
constexpr double rounding_share = 1e-9;

/// A closest point is a sum of three points, each rounded to the digits that the largest coordinate leaves; twice that
/// for the two that are compared.
double rounding_of(const Eigen::AlignedBox3d& box) {
  constexpr double units = 16;
  return box.isEmpty() ? 0
                       : units * std::numeric_limits<double>::epsilon() *
                             box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
}

fcl::Transform3d at(const Vec3& point) {
  fcl::Transform3d transform = fcl::Transform3d::Identity();
  transform.translation() = point;
  return transform;
}

/// One bone's FCL model, asked about points in the bone's rest frame by FCL's calls; from several threads at once. FCL
/// says which triangles are near; the closest point on them is then computed here, so that it does not depend on what
/// was asked of FCL to find them. FCL takes a surface for hollow: which side a point is on is SignedSurface's answer.
class FclBone {
 public:
  FclBone(const FclOptions& options, const Bone& bone)
      : m_sides(bone.kept_signed_distance()),
        m_box(bounding_box(bone.surface.mesh.vertices)),
        m_touching_m(touching_distance_m(bone.surface.mesh)),
        m_rounding_m(m_touching_m + rounding_of(m_box)),
        m_solver(to_fcl(options.narrow_phase)),
        m_by_distance(options.query == Query::node_distance),
        m_node_radius_m(options.node_radius_m),
        m_keeps_clearances(options.uses_clearance_cache && is_closed(bone.surface.mesh)),
        m_clean(bone.surface.clean) {
    with_bounding_volume(options.bounding_volume, [&](auto volume) {
      const TriangleMesh& mesh = bone.surface.mesh;
      auto model = make_fcl_model<typename decltype(volume)::type>(mesh.vertices, mesh.triangles);
      m_model_bytes = model_bytes(*model);
      m_model = std::move(model);
    });
  }

  /// Exact by distance, on a surface whose pseudo-normals tell the side. A sphere misses what is deeper than it
  /// reaches, at any depth, and reports nothing that it does not reach.
  [[nodiscard]] AnswerBound answer_bound() const {
    const double infinity = std::numeric_limits<double>::infinity();
    if (!m_by_distance) {
      return {infinity, m_clean ? m_touching_m : m_node_radius_m};
    }
    return m_clean ? AnswerBound{m_touching_m, m_touching_m} : AnswerBound{infinity, infinity};
  }

  [[nodiscard]] std::size_t bytes() const { return sizeof(*this) + m_sides->bytes() + m_model_bytes; }
  [[nodiscard]] static std::optional<StructureError> error() { return std::nullopt; }
  [[nodiscard]] const FclBone& session() const { return *this; }

  [[nodiscard]] LocatedPoint locate(const Vec3& point, int& /*near*/) const {
    double clearance_m = 0;
    const ClosestPoint closest =
        m_by_distance ? closest_by_distance(point, clearance_m) : closest_by_collision(point, clearance_m);
    if (closest.triangle >= 0 && contains(point, closest)) {
      return {.inside = true,
              .depth_m = closest.distance_m,
              .outward = (closest.point - point) / (closest.point - point).norm()};
    }
    return {.clearance_m = m_keeps_clearances ? clearance_m - m_rounding_m : 0};
  }

 private:
  /// Without a triangle for a point that is not inside; `clearance_m` is then the distance to the triangle that FCL
  /// names, or to the box.
  [[nodiscard]] ClosestPoint closest_by_distance(const Vec3& point, double& clearance_m) const {
    if (is_outside_box(point, 0)) {
      clearance_m = m_box.isEmpty() ? 0 : m_box.exteriorDistance(point);
      return {};
    }
    const fcl::Sphered node(0);
    const fcl::DistanceRequestd request(true, false, 0, 0, 1e-6, m_solver);
    fcl::DistanceResultd result;
    fcl::distance(m_model.get(), fcl::Transform3d::Identity(), &node, at(point), request, result);
    const int named = std::max(static_cast<int>(result.b1), 0);
    const ClosestOnTriangle found = m_sides->tree().closest_on(point, named);
    const ClosestPoint closest{found.point, std::sqrt(found.squared_distance_m2), named, found.feature};
    // Where a point lies in a triangle, FCL 0.7 leaves that triangle's distance unset, and names another one or this
    // one with any distance; and of several triangles at the same distance it names any. Its collision is sound in
    // both cases.
    if (contains(point, closest)) {
      return closest_met(point, (1 + rounding_share) * closest.distance_m + m_rounding_m, {named});
    }
    if (m_keeps_clearances) {
      clearance_m = std::min(result.min_distance, closest.distance_m);
      const ClosestPoint nearer = closest_met(point, clearance_m, {});
      if (nearer.triangle >= 0) clearance_m = nearer.distance_m;
    }
    return {};
  }

  /// Of an open surface, a point outside its box may count as inside, too. `clearance_m`: no triangle is nearer.
  [[nodiscard]] ClosestPoint closest_by_collision(const Vec3& point, double& clearance_m) const {
    if (is_outside_box(point, m_node_radius_m + m_rounding_m)) {
      clearance_m = m_box.isEmpty() ? 0 : m_box.exteriorDistance(point);
      return {};
    }
    const ClosestPoint closest = closest_met(point, m_node_radius_m, {});
    clearance_m = closest.triangle >= 0 ? closest.distance_m : m_node_radius_m;
    return closest;
  }

  /// The closest of `near` and of the triangles that a sphere meets, at equal distances the one with the smallest
  /// index; its index is -1 where there is none.
  [[nodiscard]] ClosestPoint closest_met(const Vec3& point, double radius_m, std::vector<int> near) const {
    const fcl::Sphered sphere(radius_m);
    fcl::CollisionRequestd request(all_contacts, false);
    request.gjk_solver_type = m_solver;
    fcl::CollisionResultd result;
    fcl::collide(m_model.get(), fcl::Transform3d::Identity(), &sphere, at(point), request, result);
    for (std::size_t i = 0; i < result.numContacts(); ++i) {
      near.push_back(static_cast<int>(result.getContact(i).b1));
    }
    ClosestPoint best;
    double squared_m2 = std::numeric_limits<double>::infinity();
    for (const int triangle : near) {
      const ClosestOnTriangle found = m_sides->tree().closest_on(point, triangle);
      if (found.squared_distance_m2 < squared_m2 ||
          (found.squared_distance_m2 == squared_m2 && triangle < best.triangle)) {
        squared_m2 = found.squared_distance_m2;
        best = {found.point, 0, triangle, found.feature};
      }
    }
    best.distance_m = std::sqrt(squared_m2);
    return best;
  }

  /// Of the bone, by more than `reach_m`; so is what is not finite.
  [[nodiscard]] bool is_outside_box(const Vec3& point, double reach_m) const {
    return !point.allFinite() || m_box.isEmpty() || m_box.exteriorDistance(point) > reach_m;
  }

  /// Not a point closer to the surface than `m_touching_m`: which side it is on is rounding.
  [[nodiscard]] bool contains(const Vec3& point, const ClosestPoint& closest) const {
    return closest.distance_m > m_touching_m && m_sides->is_inside(point, closest);
  }

  std::shared_ptr<const SignedSurface> m_sides;
  Eigen::AlignedBox3d m_box;
  double m_touching_m;
  double m_rounding_m;  ///< what distances of FCL and those that are measured here differ by
  std::shared_ptr<fcl::CollisionGeometryd> m_model;
  std::size_t m_model_bytes = 0;
  fcl::GJKSolverType m_solver;
  bool m_by_distance;
  double m_node_radius_m;
  bool m_keeps_clearances;
  bool m_clean;
};

}  // namespace

std::unique_ptr<CollisionBackend> make_node_backend(const FclOptions& options) {
  return make_point_backend({.capabilities = {.has_cache = options.uses_clearance_cache},
                             .nodes_a_batch = 16,
                             .contact_reach_m = [options](const Bone& /*bone*/) { return options.node_radius_m; },
                             .build = [options](const Bone& bone, int /*threads*/,
                                                const ShareReport& /*report*/) -> std::unique_ptr<BoneStructure> {
                               return std::make_unique<LocatedNodes<FclBone>>(
                                   std::make_unique<const FclBone>(options, bone), bone, BoxCulling::none);
                             }});
}

}  // namespace musclebench

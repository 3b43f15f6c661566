#include <cmath>
#include <coal/BVH/BVH_model.h>
#include <coal/collision.h>
#include <coal/config.hh>
#include <coal/distance.h>
#include <coal/shape/geometric_shapes.h>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "core/clearance/located_nodes.hpp"
#include "core/clearance/point_backend.hpp"
#include "core/contact/backend_entry.hpp"

namespace musclebench {

namespace {

/// One bone's model, asked about points in the bone's rest frame. Coal takes a surface for hollow: it says which
/// triangles are near, never on which side a point is. That is SignedSurface's answer.
class CoalBone {
 public:
  /// A radius of 0 stands for queries of distance.
  CoalBone(const Bone& bone, double node_radius_m)
      : m_sides(bone.kept_signed_distance()),
        m_touching_m(touching_distance_m(bone.surface.mesh)),
        m_node_radius_m(node_radius_m),
        m_is_closed(is_closed(bone.surface.mesh)),
        m_is_clean(bone.surface.clean) {
    const TriangleMesh& mesh = bone.surface.mesh;
    const Eigen::AlignedBox3d box = bounding_box(mesh.vertices);
    m_middle = box.center();
    // A closest point is a sum of three points, each rounded to the digits that the largest coordinate leaves.
    constexpr double units = 16;
    m_rounding_m = m_touching_m + units * std::numeric_limits<double>::epsilon() *
                                      box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
    std::vector<coal::Vec3s> points;
    for (const Vec3& vertex : mesh.vertices) points.emplace_back(vertex - m_middle);
    std::vector<coal::Triangle> triangles;
    for (const Triangle& triangle : mesh.triangles) {
      triangles.emplace_back(static_cast<std::size_t>(triangle[0]), static_cast<std::size_t>(triangle[1]),
                             static_cast<std::size_t>(triangle[2]));
    }
    m_model.beginModel(static_cast<unsigned>(triangles.size()), static_cast<unsigned>(points.size()));
    m_model.addSubModel(points, triangles);
    m_model.endModel();
  }
  CoalBone(const CoalBone&) = delete;
  CoalBone& operator=(const CoalBone&) = delete;

  /// Coal's function objects keep what a query needs, for one thread.
  class Session {
   public:
    explicit Session(const CoalBone& bone)
        : m_bone(bone),
          m_node(bone.m_node_radius_m),
          m_measure(&bone.m_model, &m_node),
          m_collide(&bone.m_model, &m_node) {
      m_distance_request.enable_signed_distance = false;
      m_collision_request.enable_contact = false;  // a triangle's index is told without it
      m_collision_request.num_max_contacts = bone.m_model.num_tris;
    }
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    [[nodiscard]] LocatedPoint locate(const Vec3& point, int& /*near*/) {
      double clearance_m = 0;
      const ClosestPoint closest =
          m_bone.m_node_radius_m > 0 ? closest_met(point, clearance_m) : closest_by_distance(point, clearance_m);
      if (closest.distance_m > m_bone.m_touching_m && closest.triangle >= 0 &&
          m_bone.m_sides->is_inside(point, closest)) {
        return {.inside = true, .depth_m = closest.distance_m, .outward = (closest.point - point) / closest.distance_m};
      }
      return {.clearance_m = m_bone.m_is_closed ? clearance_m - m_bone.m_rounding_m : 0};
    }

   private:
    [[nodiscard]] ClosestPoint closest_by_distance(const Vec3& point, double& clearance_m) {
      m_distance.clear();
      m_measure(coal::Transform3s(), at(point), m_distance_request, m_distance);
      if (m_distance.b1 < 0) return {};
      const ClosestPoint closest = on_triangle(point, m_distance.b1);
      clearance_m = closest.distance_m;
      return closest;
    }
    /// The closest of the triangles that the sphere meets. Where it meets none, Coal tells a bound of the distance.
    [[nodiscard]] ClosestPoint closest_met(const Vec3& point, double& clearance_m) {
      m_collision.clear();
      m_collide(coal::Transform3s(), at(point), m_collision_request, m_collision);
      ClosestPoint best{.distance_m = std::numeric_limits<double>::infinity(), .triangle = -1};
      for (const coal::Contact& contact : m_collision.getContacts()) {
        const ClosestPoint found = on_triangle(point, contact.b1);
        if (found.distance_m < best.distance_m) best = found;
      }
      clearance_m = best.triangle >= 0 ? best.distance_m : m_bone.m_node_radius_m + m_collision.distance_lower_bound;
      return best;
    }
    [[nodiscard]] coal::Transform3s at(const Vec3& point) const {
      return coal::Transform3s(coal::Vec3s(point - m_bone.m_middle));
    }
    /// Measured again, so that it does not depend on what was asked of Coal to find it.
    [[nodiscard]] ClosestPoint on_triangle(const Vec3& point, int triangle) const {
      const ClosestOnTriangle found = m_bone.m_sides->tree().closest_on(point, triangle);
      return {found.point, std::sqrt(found.squared_distance_m2), triangle, found.feature};
    }

    const CoalBone& m_bone;
    coal::Sphere m_node;
    coal::ComputeDistance m_measure;
    coal::ComputeCollision m_collide;
    coal::DistanceRequest m_distance_request;
    coal::DistanceResult m_distance;
    coal::CollisionRequest m_collision_request;
    coal::CollisionResult m_collision;
  };
  [[nodiscard]] Session session() const { return Session(*this); }

  /// Exact by distance, where pseudo-normals tell the side. A sphere misses what is deeper than it reaches.
  [[nodiscard]] AnswerBound answer_bound() const {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    if (m_node_radius_m > 0) return {infinity, m_is_clean ? m_touching_m : m_node_radius_m};
    return m_is_clean ? AnswerBound{m_touching_m, m_touching_m} : AnswerBound{infinity, infinity};
  }
  /// By the sizes of what Coal keeps: a tree of n triangles has 2 n - 1 nodes.
  [[nodiscard]] std::size_t bytes() const {
    const std::size_t triangle = 2 * (sizeof(coal::BVNode<coal::OBBRSS>) + sizeof(unsigned)) + sizeof(coal::Triangle);
    return sizeof(*this) + m_sides->bytes() + m_model.num_tris * triangle + m_model.num_vertices * sizeof(coal::Vec3s);
  }
  [[nodiscard]] static std::optional<StructureError> error() { return std::nullopt; }

 private:
  std::shared_ptr<const SignedSurface> m_sides;
  Vec3 m_middle = Vec3::Zero();
  double m_touching_m;
  double m_rounding_m = 0;
  double m_node_radius_m;
  bool m_is_closed;
  bool m_is_clean;
  coal::BVHModel<coal::OBBRSS> m_model;
};

std::unique_ptr<CollisionBackend> make_coal_backend(const Parameters& parameters) {
  const double node_radius_m = parameters.word("query") == "collide" ? parameters.number("node_radius_m") : 0;
  return make_point_backend({.capabilities = {.has_cache = uses_clearance_cache(parameters)},
                             .nodes_a_batch = 16,
                             .contact_reach_m = [](const Bone& bone) { return touching_distance_m(bone.surface.mesh); },
                             .build = build_located(parameters, [node_radius_m](const Bone& bone, int /*threads*/,
                                                                                const ShareReport& /*report*/) {
                               return std::make_unique<const CoalBone>(bone, node_radius_m);
                             })});
}

}  // namespace

// How it is driven follows the comments of Coal's collision.h and collision_data.h, and its README.
BackendEntry coal_entry() {
  return {.name = "coal",
          .help = "Coal, FCL's heir in robotics: the distance of each node, or a small sphere that collides",
          .implementation = "Coal " COAL_VERSION ", BSD-3-Clause",
          .default_response = ResponseKind::project,
          .parameters = {parameter::choice(
                             {.name = "query",
                              .choices = {"distance", "collide"},
                              .help = "distance: of each node to the bone's triangles. collide: a small sphere at each "
                                      "node with them; misses nodes deeper than the radius"}),
                         parameter::number({.name = "node_radius_m",
                                            .unit = "m",
                                            .default_value = 0.002,
                                            .minimum = 1e-9,
                                            .maximum = 1,
                                            .help = "radius of the spheres of collide"}),
                         cull_parameter(), clearance_cache_parameter()},
          .make = make_coal_backend};
}

}  // namespace musclebench

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fcpw/fcpw.h>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "core/clearance/located_nodes.hpp"
#include "core/clearance/point_backend.hpp"
#include "core/contact/backend_entry.hpp"
#include "core/distance/triangle_distance.hpp"

namespace musclebench {

namespace {

#ifdef FCPW_USE_ENOKI
constexpr bool is_wide = true;
#else
constexpr bool is_wide = false;
#endif

/// Of a coordinate of the surface and one of the point, and what FCPW rounds as it compares them.
constexpr double rounding_units = 16;
constexpr double float_epsilon = std::numeric_limits<float>::epsilon();

/// FCPW computes in single precision, so the surface is kept relative to its middle. By a constant it takes triangles
/// for parallel to a ray that are small, so the surface is kept at a size of 1.
class FcpwBone {
 public:
  FcpwBone(const Bone& bone, bool counts_hits, bool starts_warm)
      : m_mesh(bone.surface.mesh),
        m_middle(bounding_box(m_mesh.vertices).center()),
        m_size_m(bounding_box(m_mesh.vertices).diagonal().norm()),
        m_touching_m(touching_distance_m(m_mesh)),
        m_is_closed(is_closed(m_mesh)),
        m_is_clean(bone.surface.clean),
        m_counts_hits(counts_hits),
        m_starts_warm(starts_warm) {
    std::vector<fcpw::Vector3> positions;
    for (const Vec3& vertex : m_mesh.vertices) positions.push_back(to_fcpw(vertex));
    std::vector<fcpw::Vector3i> triangles;
    for (const Triangle& triangle : m_mesh.triangles) triangles.emplace_back(triangle[0], triangle[1], triangle[2]);
    m_scene.setObjectCount(1);
    m_scene.setObjectVertices(positions, 0);
    m_scene.setObjectTriangles(triangles, 0);
    m_scene.build(fcpw::AggregateType::Bvh_SurfaceArea, is_wide);
  }

  /// FCPW's triangle is one of the closest, to rounding. Where it counts hits, a ray that slips through an edge is
  /// wrong at any depth; its first hit is sure, where the surface is clean.
  [[nodiscard]] AnswerBound answer_bound() const {
    const double side_m =
        m_is_clean && !m_counts_hits ? m_touching_m + rounding_m() : std::numeric_limits<double>::infinity();
    return {side_m, side_m, rounding_m()};
  }
  /// By the sizes of what FCPW keeps: a triangle is an object, a pointer to it and three indices, and about one node of
  /// the tree. FCPW does not tell the size of that.
  [[nodiscard]] std::size_t bytes() const {
    const std::size_t triangle = sizeof(fcpw::Triangle) + sizeof(void*) + 3 * sizeof(int) + sizeof(fcpw::BvhNode<3>);
    return sizeof(*this) + m_mesh.triangles.size() * triangle + m_mesh.vertices.size() * sizeof(fcpw::Vector3);
  }
  [[nodiscard]] static std::optional<StructureError> error() { return std::nullopt; }
  [[nodiscard]] const FcpwBone& session() const { return *this; }

  [[nodiscard]] LocatedPoint locate(const Vec3& point, int& near) const {
    const fcpw::Vector3 query = to_fcpw(point);
    // A point far away is rounded by more than one at the surface.
    const double rounding_here_m = rounding_m() * std::max(1.0, static_cast<double>(query.cwiseAbs().maxCoeff()));
    fcpw::Interaction<3> found;
    float squared_reach = fcpw::maxFloat;
    if (near >= 0 && m_starts_warm) {
      const double reach = (std::sqrt(on_triangle(point, near).squared_distance_m2) + rounding_here_m) / m_size_m;
      squared_reach = static_cast<float>(reach * reach);
    }
    if (!m_scene.findClosestPoint(query, found, squared_reach)) return {};
    near = found.primitiveIndex;
    const ClosestOnTriangle closest = on_triangle(point, near);
    const double distance_m = std::sqrt(closest.squared_distance_m2);
    if (distance_m > m_touching_m && is_inside(query)) {
      return {.inside = true, .depth_m = distance_m, .outward = (closest.point - point) / distance_m};
    }
    // Rays may err on the side of a point this close; one that is farther away is free as far as the surface.
    return {.clearance_m = m_is_closed ? distance_m - rounding_here_m : 0};
  }

 private:
  [[nodiscard]] double rounding_m() const { return rounding_units * float_epsilon * m_size_m; }
  [[nodiscard]] fcpw::Vector3 to_fcpw(const Vec3& point) const {
    return Vec3((point - m_middle) / m_size_m).cast<float>();
  }
  [[nodiscard]] bool is_inside(const fcpw::Vector3& query) const {
    if (m_counts_hits) return m_scene.contains(query);
    // No component is 0, by which FCPW would divide.
    fcpw::Ray<3> ray(query, fcpw::Vector3(0.8017F, 0.2673F, 0.5345F));
    fcpw::Interaction<3> hit;
    return m_scene.intersectRobust(ray, hit) && hit.n.dot(ray.d) > 0;
  }
  /// In double precision: FCPW says which triangle is near, not how near to the last digit.
  [[nodiscard]] ClosestOnTriangle on_triangle(const Vec3& point, int triangle) const {
    const auto& [a, b, c] = m_mesh.triangles[static_cast<std::size_t>(triangle)];
    return closest_on_triangle(point, m_mesh.vertices[static_cast<std::size_t>(a)],
                               m_mesh.vertices[static_cast<std::size_t>(b)],
                               m_mesh.vertices[static_cast<std::size_t>(c)]);
  }

  const TriangleMesh& m_mesh;
  Vec3 m_middle;
  double m_size_m;
  double m_touching_m;
  bool m_is_closed;
  bool m_is_clean;
  bool m_counts_hits;
  bool m_starts_warm;
  fcpw::Scene<3> m_scene;
};

std::unique_ptr<CollisionBackend> make_fcpw_backend(const Parameters& parameters) {
  return make_point_backend(
      {.capabilities = {.has_cache = uses_clearance_cache(parameters)},
       .nodes_a_batch = 64,
       .contact_reach_m =
           [](const Bone& bone) { return 1e-5 * bounding_box(bone.surface.mesh.vertices).diagonal().norm(); },
       .build = build_located(parameters, [counts_hits = parameters.word("side") == "contains",
                                           starts_warm = parameters.flag("warm_start")](
                                              const Bone& bone, int /*threads*/, const ShareReport& /*report*/) {
         return std::make_unique<const FcpwBone>(bone, counts_hits, starts_warm);
       })});
}

}  // namespace

// How it is driven follows FCPW's README, the comments of its fcpw.h, and its issue 14 and pull request 22 on rays that
// miss.
BackendEntry fcpw_entry() {
  return {.name = "fcpw",
          .help = "closest point by FCPW's tree over each bone, side by a ray's first hit",
          .implementation = is_wide ? "FCPW with Enoki, MIT" : "FCPW, MIT",
          .default_response = ResponseKind::project,
          .parameters = {parameter::choice({.name = "side",
                                            .choices = {"first_hit", "contains"},
                                            .help = "what tells the side of a node. first_hit: which way the triangle "
                                                    "faces that a watertight ray meets first. contains: FCPW's own "
                                                    "count of what two rays meet, which may slip through an edge"}),
                         parameter::flag({.name = "warm_start",
                                          .default_value = true,
                                          .help = "search no farther than the triangle that was closest last"}),
                         cull_parameter(), clearance_cache_parameter()},
          .make = make_fcpw_backend};
}

}  // namespace musclebench

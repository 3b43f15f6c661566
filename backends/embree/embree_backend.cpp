#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "backends/embree/embree_scene.hpp"
#include "backends/embree/muscle_detector.hpp"
#include "core/clearance/located_triangles.hpp"
#include "core/clearance/point_backend.hpp"
#include "core/contact/backend_entry.hpp"

namespace musclebench {

namespace {

class EmbreeBone {
 public:
  EmbreeBone(const Bone& bone, const EmbreeSettings& settings, bool starts_warm)
      : m_scene(bone.surface.mesh, bone.surface.mesh.triangles, settings),
        m_touching_m(touching_distance_m(bone.surface.mesh)),
        m_starts_warm(starts_warm) {}

  [[nodiscard]] int closest(const Vec3& point, int near) const {
    constexpr double anywhere_m = std::numeric_limits<float>::max() / 4;
    return m_scene.closest(point, m_starts_warm ? near : -1, anywhere_m).triangle;
  }
  void list_within(const Vec3& point, double radius_m, ListedTriangles& list) const {
    m_scene.list_within(point, radius_m, list);
  }
  [[nodiscard]] bool is_inside(const Vec3& point) const { return m_scene.is_inside(point); }
  [[nodiscard]] std::optional<double> way_out_m(const Vec3& from, const Vec3& direction, double length_m) const {
    return m_scene.way_out_m(from, direction, length_m);
  }
  /// Closest points are exact; the side of a point that single precision moves to the other one is not.
  [[nodiscard]] AnswerBound answer_bound() const {
    const double side_m = m_touching_m + m_scene.rounding_m();
    return {side_m, side_m, m_scene.rounding_m()};
  }
  [[nodiscard]] std::size_t bytes() const { return m_scene.bytes(); }

 private:
  EmbreeScene m_scene;
  double m_touching_m;
  bool m_starts_warm;
};

auto bone_maker(const Parameters& parameters) {
  const EmbreeSettings settings{.rays = static_cast<int>(parameters.integer("rays")),
                                .robust = parameters.flag("robust"),
                                .high_quality = parameters.word("quality") == "high"};
  return [settings, starts_warm = parameters.flag("warm_start")](const Bone& bone) {
    return std::make_unique<const EmbreeBone>(bone, settings, starts_warm);
  };
}

std::unique_ptr<CollisionBackend> make_embree_backend(const Parameters& parameters) {
  return make_point_backend(
      {.capabilities = {.has_cache = uses_clearance_cache(parameters), .steady_memory = true},
       .nodes_a_batch = 64,
       .contact_reach_m =
           [](const Bone& bone) { return 1e-5 * bounding_box(bone.surface.mesh.vertices).diagonal().norm(); },
       .build = build_on_triangles(parameters, bone_maker(parameters))});
}

}  // namespace

// How it is driven follows Embree's API manual (version 3.13, "rtcPointQuery", "rtcSetSceneFlags",
// "rtcSetGeometryBuildQuality") and its threads 387, 416 and 423 on missed edges and large coordinates.
BackendEntry embree_entry() {
  return {.name = "embree",
          .help = "closest point by Embree's tree over each bone, side by rays that vote",
          .implementation = "Embree " RTC_VERSION_STRING ", Apache-2.0",
          .default_response = ResponseKind::project,
          .parameters = {parameter::integer({.name = "rays",
                                             .default_value = 3,
                                             .minimum = 1,
                                             .maximum = 9,
                                             .help = "rays that vote on the side of a node, odd: more are surer"}),
                         parameter::flag(
                             {.name = "robust", .default_value = true, .help = "rays do not slip between triangles"}),
                         parameter::choice({.name = "quality",
                                            .choices = {"high", "medium"},
                                            .help = "of the tree: high splits triangles and builds longer"}),
                         parameter::flag({.name = "warm_start",
                                          .default_value = true,
                                          .help = "begin with the triangle that was closest to the node last"}),
                         cull_parameter(), clearance_cache_parameter()},
          .make = make_embree_backend,
          .make_muscle_detector = make_embree_muscle_detector,
          .make_surface_queries = [](const Parameters& parameters, std::span<const Bone> /*bones*/) {
            return queries_on_triangles(bone_maker(parameters));
          }};
}

}  // namespace musclebench

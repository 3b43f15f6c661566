#include "backends/fcl/nodes/node_backend.hpp"

#include <limits>

#include "backends/fcl/nodes/node_surface.hpp"
#include "core/clearance/point_backend.hpp"

namespace musclebench {

namespace {

class NodeStructure final : public BoneStructure {
 public:
  NodeStructure(const FclOptions& options, const Bone& bone)
      : m_surface(options, bone),
        m_by_distance(options.query == Query::node_distance),
        m_node_radius_m(options.node_radius_m),
        m_clean(bone.surface.clean) {}

  /// Exact by distance, on a surface whose pseudo-normals tell the side. A sphere misses what is deeper than it
  /// reaches, at any depth, and reports nothing that it does not reach.
  [[nodiscard]] AnswerBound answer_bound() const override {
    const double infinity = std::numeric_limits<double>::infinity();
    if (!m_by_distance) {
      return {infinity, m_clean ? m_surface.touching_m() : m_node_radius_m};
    }
    return m_clean ? AnswerBound{m_surface.touching_m(), m_surface.touching_m()} : AnswerBound{infinity, infinity};
  }

  [[nodiscard]] std::size_t bytes() const override { return m_surface.bytes(); }

  void detect(const NodeBatch& batch, std::vector<Contact>& contacts) override {
    for (const int node : batch.nodes) {
      const Vec3 point = batch.pose.apply_inverse(batch.positions[static_cast<std::size_t>(node)]);
      const ClosestPoint closest = m_by_distance ? closest_by_distance(point) : closest_by_collision(point);
      if (closest.triangle >= 0 && m_surface.contains(point, closest)) {
        const Vec3 outward = NodeSurface::outward(point, closest);
        contacts.push_back({node, batch.bone, closest.distance_m, batch.pose.apply_to_direction(outward)});
      }
    }
  }

 private:
  /// Without a triangle for a point that is not inside.
  [[nodiscard]] ClosestPoint closest_by_distance(const Vec3& point) const {
    if (m_surface.is_outside_box(point, 0)) {
      return {};
    }
    const ClosestPoint closest = m_surface.closest(point);
    return m_surface.contains(point, closest) ? m_surface.settled(point, closest) : ClosestPoint{};
  }

  /// Of an open surface, a point outside its box may count as inside, too.
  [[nodiscard]] ClosestPoint closest_by_collision(const Vec3& point) const {
    return m_surface.is_outside_box(point, m_node_radius_m + m_surface.rounding_m()) ? ClosestPoint{}
                                                                                     : m_surface.closest_met(point);
  }

  NodeSurface m_surface;
  bool m_by_distance;
  double m_node_radius_m;
  bool m_clean;
};

}  // namespace

std::unique_ptr<CollisionBackend> make_node_backend(const FclOptions& options) {
  return make_point_backend(
      {.capabilities = {},
       .nodes_a_batch = 16,
       .contact_reach_m = [options](const Bone& /*bone*/) { return options.node_radius_m; },
       .build = [options](const Bone& bone, int /*threads*/,
                          const ShareReport& /*report*/) { return std::make_unique<NodeStructure>(options, bone); }});
}

}  // namespace musclebench

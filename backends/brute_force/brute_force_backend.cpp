#include "backends/brute_force/brute_force_backend.hpp"

#include "backends/brute_force/brute_force_surface.hpp"
#include "backends/brute_force/muscle_detector.hpp"
#include "core/clearance/point_backend.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

class AllTriangles final : public BoneStructure {
 public:
  explicit AllTriangles(const TriangleMesh& mesh) : m_mesh(mesh), m_touching_m(touching_distance_m(mesh)) {}

  [[nodiscard]] AnswerBound answer_bound() const override { return {m_touching_m, 0}; }
  [[nodiscard]] std::size_t bytes() const override { return 0; }

  void detect(const NodeBatch& batch, std::vector<Contact>& contacts) override {
    for (const int node : batch.nodes) {
      const Vec3 point = batch.pose.apply_inverse(batch.positions[static_cast<std::size_t>(node)]);
      const SurfacePoint found = locate_by_brute_force(m_mesh, point);
      if (found.inside && found.distance_m > m_touching_m) {
        contacts.push_back({node, batch.bone, found.distance_m, batch.pose.apply_to_direction(found.normal)});
      }
    }
  }

 private:
  const TriangleMesh& m_mesh;
  double m_touching_m;
};

}  // namespace

std::unique_ptr<CollisionBackend> make_brute_force_backend(const Parameters& /*parameters*/) {
  return make_point_backend(
      {.capabilities = {},
       .nodes_a_batch = 16,
       .contact_reach_m = [](const Bone& /*bone*/) { return 0.0; },
       .build = [](const Bone& bone, int /*threads*/,
                   const ShareReport& /*report*/) { return std::make_unique<AllTriangles>(bone.surface.mesh); }});
}

BackendEntry brute_force_entry() {
  return {.name = "brute_force",
          .help = "every node against every triangle: the truth of contacts",
          .implementation = "this project",
          .default_response = ResponseKind::project,
          .exact = true,
          .make = make_brute_force_backend,
          .signed_distance = [](const Bone& bone, int /*threads*/) -> SignedDistance {
            return [&mesh = bone.surface.mesh](const Vec3& point) {
              const SurfacePoint found = locate_by_brute_force(mesh, point);
              return found.inside ? -found.distance_m : found.distance_m;
            };
          },
          .make_muscle_detector = make_brute_force_muscle_detector};
}

}  // namespace musclebench

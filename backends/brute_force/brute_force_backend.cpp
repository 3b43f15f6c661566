#include "backends/brute_force/brute_force_backend.hpp"

#include "backends/brute_force/brute_force_surface.hpp"
#include "backends/brute_force/muscle_detector.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

class BruteForceBackend final : public CollisionBackend {
 public:
  [[nodiscard]] Capabilities capabilities() const override { return {}; }
  [[nodiscard]] AnswerBound answer_bound(int bone) const override {
    return {m_touching_m[static_cast<std::size_t>(bone)], 0};
  }
  [[nodiscard]] std::size_t structure_bytes() const override { return 0; }

 private:
  void do_build() override {
    m_touching_m.clear();
    for (const Bone& bone : bones()) {
      m_touching_m.push_back(touching_distance_m(bone.surface.mesh));
    }
  }

  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    m_points.resize(nodes.size());
    const auto count = static_cast<std::ptrdiff_t>(nodes.size());
    for (std::size_t bone = 0; bone < bones().size(); ++bone) {
      const TriangleMesh& mesh = bones()[bone].surface.mesh;
      const RigidMotion& pose = poses()[bone];
#pragma omp parallel for num_threads(threads()) schedule(dynamic, 16)
      for (std::ptrdiff_t i = 0; i < count; ++i) {
        m_points[i] = locate_by_brute_force(mesh, pose.apply_inverse(positions[nodes[i]]));
      }
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (m_points[i].inside && m_points[i].distance_m > m_touching_m[bone]) {
          contacts.push_back(
              {nodes[i], static_cast<int>(bone), m_points[i].distance_m, pose.apply_to_direction(m_points[i].normal)});
        }
      }
    }
  }

  std::vector<double> m_touching_m;  ///< by bone
  std::vector<SurfacePoint> m_points;
};

}  // namespace

std::unique_ptr<CollisionBackend> make_brute_force_backend(const Parameters& /*parameters*/) {
  return std::make_unique<BruteForceBackend>();
}

BackendEntry brute_force_entry() {
  return {.name = "brute_force",
          .help = "every node against every triangle: the truth of contacts",
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

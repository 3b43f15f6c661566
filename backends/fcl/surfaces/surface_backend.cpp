#include "backends/fcl/surfaces/surface_backend.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "backends/fcl/surfaces/node_contacts.hpp"
#include "backends/fcl/surfaces/surface_collider.hpp"

namespace musclebench {

namespace {

double longest_edge_m(const TriangleMesh& mesh) {
  double squared = 0;
  for (const Triangle& triangle : mesh.triangles) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vec3& from = mesh.vertices[static_cast<std::size_t>(triangle[corner])];
      const Vec3& to = mesh.vertices[static_cast<std::size_t>(triangle[(corner + 1) % 3])];
      squared = std::max(squared, (to - from).squaredNorm());
    }
  }
  return std::sqrt(squared);
}

class SurfaceBackend final : public CollisionBackend {
 public:
  explicit SurfaceBackend(FclOptions options) : m_options(std::move(options)) {}

  [[nodiscard]] Capabilities capabilities() const override {
    return {.depth = true, .point_queries = false, .times_pairs = true};
  }

  /// Nodes behind the surface are missed at any depth; a node that is reported hangs on a triangle that cuts the bone
  /// (as long as the muscle's edges are not stretched).
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override {
    return {std::numeric_limits<double>::infinity(), longest_edge_m(muscle())};
  }

  [[nodiscard]] double contact_reach_m(const Bone& /*bone*/) const override { return 0; }

  [[nodiscard]] std::size_t structure_bytes() const override {
    return m_collider == nullptr ? 0 : m_collider->bytes() + m_contacts->bytes();
  }

 private:
  void do_build() override {
    m_bones.clear();
    m_asked.clear();
    for (std::size_t bone = 0; bone < bones().size(); ++bone) {
      if (is_pruned(bone)) continue;
      m_bones.push_back(static_cast<int>(bone));
      m_asked.push_back(&bones()[bone]);
    }
    std::vector<MuscleSurface> surfaces;
    for (const Body& each : muscles()) surfaces.push_back(muscle_surface(muscle(), each, "fcl: muscle"));
    if (surfaces.empty()) surfaces.push_back(muscle_surface(muscle(), "fcl: muscle"));
    m_collider = make_surface_collider(m_options, m_asked, std::move(surfaces), threads());
    m_contacts = std::make_unique<NodeContacts>(m_asked, muscle().triangles, muscle().vertices.size());
  }

  void do_update(std::span<const Vec3> positions) override {
    m_asked_poses.clear();
    for (const int bone : m_bones) m_asked_poses.push_back(poses()[static_cast<std::size_t>(bone)]);
    m_collider->move_bones(m_asked_poses);
    for (std::size_t muscle = 0; muscle < count(); ++muscle) m_collider->deform(muscle, positions);
  }

  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    if (nodes.empty()) {
      return;
    }
    m_collider->collide_bones(m_pairs);
    for (std::size_t pair = 0; pair < m_pairs.size(); ++pair) {
      const Nanoseconds start_ns = monotonic_now_ns();
      const std::size_t asked = pair / count();
      const auto first = static_cast<std::ptrdiff_t>(contacts.size());
      m_contacts->append(static_cast<int>(asked), m_asked_poses[asked], m_pairs[pair], positions,
                         nodes_of(pair % count(), nodes), contacts);
      std::for_each(contacts.begin() + first, contacts.end(), [&](Contact& contact) { contact.bone = m_bones[asked]; });
      if (muscles().empty()) continue;
      add_pair_time(static_cast<std::size_t>(m_bones[asked]), pair % count(),
                    m_collider->times()[pair] + monotonic_now_ns() - start_ns);
    }
  }

  /// All are one where they are not told apart.
  [[nodiscard]] std::size_t count() const { return std::max<std::size_t>(1, muscles().size()); }

  [[nodiscard]] std::span<const int> nodes_of(std::size_t index, std::span<const int> nodes) const {
    if (muscles().empty()) {
      return nodes;
    }
    const Body& own = muscles()[index];
    const auto first = std::ranges::lower_bound(nodes, own.first_node);
    return {first, std::ranges::lower_bound(first, nodes.end(), own.last_node)};
  }

  FclOptions m_options;
  std::unique_ptr<SurfaceCollider> m_collider;
  std::unique_ptr<NodeContacts> m_contacts;
  // One a bone that is asked about.
  std::vector<int> m_bones;
  std::vector<const Bone*> m_asked;
  std::vector<RigidMotion> m_asked_poses;
  std::vector<std::vector<TrianglePair>> m_pairs;  ///< by bone that is asked about, then by muscle
};

}  // namespace

std::unique_ptr<CollisionBackend> make_surface_backend(const FclOptions& options) {
  return std::make_unique<SurfaceBackend>(options);
}

}  // namespace musclebench

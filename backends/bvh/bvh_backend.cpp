#include "backends/bvh/bvh_backend.hpp"

#include "backends/bvh/centred_surface.hpp"

namespace musclebench {

namespace {

class BvhBackend final : public CollisionBackend {
 public:
  [[nodiscard]] Capabilities capabilities() const override { return {}; }
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override { return {}; }

  [[nodiscard]] std::size_t structure_bytes() const override {
    std::size_t bytes = 0;
    for (const CentredSurface& surface : m_surfaces) {
      bytes += surface.bytes();
    }
    return bytes;
  }

 private:
  void do_build() override {
    m_surfaces.clear();
    m_surfaces.reserve(bones().size());
    for (const Bone& bone : bones()) {
      m_surfaces.emplace_back(bone.surface);
    }
  }

  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    m_found.resize(nodes.size());
    m_inside.resize(nodes.size());
    for (std::size_t bone = 0; bone < m_surfaces.size(); ++bone) {
      detect_bone(static_cast<int>(bone), positions, nodes);
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (m_inside[i] != 0) {
          contacts.push_back(m_found[i]);
        }
      }
    }
  }

  /// Every node for itself, so that the answer does not depend on how many threads share them.
  void detect_bone(int bone, std::span<const Vec3> positions, std::span<const int> nodes) {
    const CentredSurface& surface = m_surfaces[static_cast<std::size_t>(bone)];
    const RigidMotion& pose = poses()[static_cast<std::size_t>(bone)];
    const auto ask = [&](std::size_t place) {
      const Vec3 rest_point = pose.apply_inverse(positions[static_cast<std::size_t>(nodes[place])]);
      Penetration found;
      m_inside[place] = static_cast<unsigned char>(surface.penetrates(rest_point, found));
      if (m_inside[place] != 0) {
        m_found[place] = {nodes[place], bone, found.depth_m, pose.apply_to_direction(found.normal)};
      }
    };
    const auto count = static_cast<std::ptrdiff_t>(nodes.size());
    if (threads() == 1) {  // not even OpenMP's team of one, which is allocated anew each time
      for (std::ptrdiff_t i = 0; i < count; ++i) {
        ask(static_cast<std::size_t>(i));
      }
      return;
    }
#pragma omp parallel for num_threads(threads()) schedule(dynamic, 64)
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      ask(static_cast<std::size_t>(i));
    }
  }

  std::vector<CentredSurface> m_surfaces;  ///< one a bone
  std::vector<Contact> m_found;            ///< by place in `nodes`, valid where m_inside
  std::vector<unsigned char> m_inside;
};

}  // namespace

std::unique_ptr<CollisionBackend> make_bvh_backend(const Parameters& /*parameters*/) {
  return std::make_unique<BvhBackend>();
}

std::vector<ParameterSpec> bvh_parameters() { return {}; }

}  // namespace musclebench

#include "backends/bvh/bvh_backend.hpp"

#include "core/geometry/signed_surface.hpp"

namespace musclebench {

namespace {

/// A bone about the middle of its box, so that one far from the origin loses no digits.
class CentredBone {
 public:
  explicit CentredBone(const Bone& bone) : CentredBone(bone.surface, box_of(bone.surface.mesh)) {}

  /// The contact of a node at `rest_point`, a point in the bone's rest frame; false where it is not inside.
  [[nodiscard]] bool collide(const Vec3& rest_point, double& depth_m, Vec3& normal) const {
    const Vec3 point = rest_point - m_centre_m;
    // Written so that what is not a number is outside. Inside an open surface may be outside its box.
    const bool in_box = (point.cwiseAbs().array() <= m_half_extents_m.array()).all();
    if (!in_box && (m_surface.closed() || !point.allFinite())) {
      return false;
    }
    const SignedPoint place = m_surface.locate(point);
    if (place.inside) {
      depth_m = place.closest.distance_m;
      normal = m_surface.outward(point, place);
    }
    return place.inside;
  }

  [[nodiscard]] std::size_t bytes() const { return sizeof(CentredBone) + m_surface.bytes(); }

 private:
  static Eigen::AlignedBox3d box_of(const TriangleMesh& mesh) {
    Eigen::AlignedBox3d box;
    for (const Vec3& vertex : mesh.vertices) {
      box.extend(vertex);
    }
    return box;
  }

  static RepairedMesh moved(RepairedMesh surface, const Vec3& by) {
    for (Vec3& vertex : surface.mesh.vertices) {
      vertex += by;
    }
    return surface;
  }

  CentredBone(const RepairedMesh& surface, const Eigen::AlignedBox3d& box)
      : m_centre_m(box.center()),
        m_half_extents_m((box.max() - m_centre_m).cwiseMax(m_centre_m - box.min())),
        m_surface(moved(surface, -m_centre_m)) {}

  Vec3 m_centre_m;
  Vec3 m_half_extents_m;
  SignedSurface m_surface;
};

class BvhBackend final : public CollisionBackend {
 public:
  [[nodiscard]] Capabilities capabilities() const override { return {}; }
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override { return {}; }

  [[nodiscard]] std::size_t structure_bytes() const override {
    std::size_t bytes = 0;
    for (const CentredBone& bone : m_bones) {
      bytes += bone.bytes();
    }
    return bytes;
  }

 private:
  void do_build() override {
    m_bones.clear();
    m_bones.reserve(bones().size());
    for (const Bone& bone : bones()) {
      m_bones.emplace_back(bone);
    }
  }

  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    m_found.resize(nodes.size());
    m_inside.resize(nodes.size());
    for (std::size_t bone = 0; bone < m_bones.size(); ++bone) {
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
    const CentredBone& shape = m_bones[static_cast<std::size_t>(bone)];
    const RigidMotion& pose = poses()[static_cast<std::size_t>(bone)];
    const auto count = static_cast<std::ptrdiff_t>(nodes.size());
#pragma omp parallel for num_threads(threads()) schedule(dynamic, 64) if (threads() > 1)
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const auto place = static_cast<std::size_t>(i);
      const Vec3 rest_point = pose.apply_inverse(positions[static_cast<std::size_t>(nodes[place])]);
      Contact& found = m_found[place];
      m_inside[place] = static_cast<unsigned char>(shape.collide(rest_point, found.depth_m, found.normal));
      if (m_inside[place] != 0) {
        found = {nodes[place], bone, found.depth_m, pose.apply_to_direction(found.normal)};
      }
    }
  }

  std::vector<CentredBone> m_bones;
  std::vector<Contact> m_found;  ///< by place in `nodes`, valid where m_inside
  std::vector<unsigned char> m_inside;
};

}  // namespace

std::unique_ptr<CollisionBackend> make_bvh_backend(const Parameters& /*parameters*/) {
  return std::make_unique<BvhBackend>();
}

std::vector<ParameterSpec> bvh_parameters() { return {}; }

}  // namespace musclebench

#include "backends/fcl/surfaces/surface_collider.hpp"

#include <limits>

#include <fcl/narrowphase/collision.h>

#include "backends/fcl/surfaces/bone_objects.hpp"
#include "backends/fcl/surfaces/deforming_model.hpp"

namespace musclebench {

namespace {

template <typename BoundingVolume>
class FclSurfaceCollider final : public SurfaceCollider {
 public:
  FclSurfaceCollider(const FclOptions& options, std::span<const Bone* const> bones,
                     std::span<const Vec3> rest_positions, std::span<const Triangle> muscle_triangles, int threads)
      : m_threads(threads),
        m_request(std::numeric_limits<std::size_t>::max()),
        m_results(bones.size()),
        m_muscle(options, rest_positions, muscle_triangles) {
    m_request.gjk_solver_type = to_fcl(options.narrow_phase);
    std::vector<std::shared_ptr<fcl::CollisionGeometryd>> models;
    for (const Bone* bone : bones) {
      auto model = make_fcl_model<BoundingVolume>(bone->surface.mesh.vertices, bone->surface.mesh.triangles);
      m_bone_model_bytes += model_bytes(*model);
      models.push_back(std::move(model));
    }
    m_bones = std::make_unique<BoneObjects>(options.broad_phase, std::move(models));
  }

  void update(std::span<const RigidMotion> bone_poses, std::span<const Vec3> positions) override {
    m_bones->move(bone_poses);
    m_muscle.update(positions);
  }

  void collide(std::vector<std::vector<TrianglePair>>& pairs_by_bone) override {
    pairs_by_bone.resize(m_bones->size());
    for (auto& pairs : pairs_by_bone) {
      pairs.clear();
    }
    if (!m_muscle.finite()) {
      return;
    }
    m_bones->overlapping(m_muscle.object(), m_overlapping);
    const auto count = static_cast<std::ptrdiff_t>(m_overlapping.size());
#pragma omp parallel for num_threads(m_threads) schedule(dynamic, 1)
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const std::size_t bone = m_overlapping[static_cast<std::size_t>(i)];
      collide_bone(bone, pairs_by_bone[bone]);
    }
  }

  [[nodiscard]] std::size_t bytes() const override { return m_muscle.bytes() + m_bones->bytes() + m_bone_model_bytes; }

 private:
  /// Reads the models, and writes only what belongs to the bone: several threads may be in here, each with its bone.
  void collide_bone(std::size_t bone, std::vector<TrianglePair>& pairs) {
    fcl::CollisionResultd& result = m_results[bone];
    result.clear();
    fcl::collide(&m_muscle.object(), &m_bones->object(bone), m_request, result);
    for (std::size_t i = 0; i < result.numContacts(); ++i) {
      // Only the indices: with boxes that are not oriented, o1 and o2 point to copies that FCL has deleted by now.
      const fcl::Contactd& contact = result.getContact(i);
      pairs.push_back({static_cast<int>(contact.b1), static_cast<int>(contact.b2)});
    }
  }

  int m_threads;
  fcl::CollisionRequestd m_request;
  std::vector<fcl::CollisionResultd> m_results;  ///< by bone
  DeformingModel<BoundingVolume> m_muscle;
  std::unique_ptr<BoneObjects> m_bones;
  std::vector<std::size_t> m_overlapping;
  std::size_t m_bone_model_bytes = 0;
};

}  // namespace

std::unique_ptr<SurfaceCollider> make_surface_collider(const FclOptions& options, std::span<const Bone* const> bones,
                                                       std::span<const Vec3> rest_positions,
                                                       std::span<const Triangle> muscle_triangles, int threads) {
  return with_bounding_volume(options.bounding_volume, [&](auto volume) -> std::unique_ptr<SurfaceCollider> {
    return std::make_unique<FclSurfaceCollider<typename decltype(volume)::type>>(options, bones, rest_positions,
                                                                                 muscle_triangles, threads);
  });
}

}  // namespace musclebench

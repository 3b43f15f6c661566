#include "backends/fcl/surfaces/surface_collider.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include <fcl/narrowphase/collision.h>

#include "backends/fcl/surfaces/bone_objects.hpp"
#include "backends/fcl/surfaces/deforming_model.hpp"

namespace musclebench {

namespace {

template <typename BoundingVolume>
class FclSurfaceCollider final : public SurfaceCollider {
 public:
  FclSurfaceCollider(const FclOptions& options, std::span<const Bone* const> bones, std::vector<MuscleSurface> muscles,
                     int threads)
      : m_threads(threads), m_request(std::numeric_limits<std::size_t>::max()), m_muscles(std::move(muscles)) {
    for (const MuscleSurface& muscle : m_muscles) {
      m_models.push_back(
          std::make_unique<DeformingModel<BoundingVolume>>(options, muscle.rest_positions, muscle.local_triangles));
    }
    m_request.gjk_solver_type = to_fcl(options.narrow_phase);
    std::vector<std::shared_ptr<fcl::CollisionGeometryd>> models;
    for (const Bone* bone : bones) {
      auto model = make_fcl_model<BoundingVolume>(bone->surface.mesh.vertices, bone->surface.mesh.triangles);
      m_bone_model_bytes += model_bytes(*model);
      models.push_back(std::move(model));
    }
    m_bones = std::make_unique<BoneObjects>(options.broad_phase, std::move(models));
    m_results.resize(bones.size() * m_muscles.size());
    m_times_ns.resize(m_results.size());
  }

  void move_bones(std::span<const RigidMotion> poses) override { m_bones->move(poses); }

  void deform(std::size_t muscle, std::span<const Vec3> positions) override {
    m_models[muscle]->update(positions.subspan(static_cast<std::size_t>(m_muscles[muscle].first_node),
                                               m_muscles[muscle].rest_positions.size()));
  }

  void collide_bones(std::vector<std::vector<TrianglePair>>& pairs) override {
    pairs.resize(m_results.size());
    for (auto& list : pairs) {
      list.clear();
    }
    std::ranges::fill(m_times_ns, Nanoseconds{0});
    m_overlapping.clear();
    for (std::size_t muscle = 0; muscle < m_muscles.size(); ++muscle) {
      if (!m_models[muscle]->finite()) continue;
      m_bones->overlapping(m_models[muscle]->object(), m_near_bones);
      for (const std::size_t bone : m_near_bones) m_overlapping.push_back(bone * m_muscles.size() + muscle);
    }
    const auto count = static_cast<std::ptrdiff_t>(m_overlapping.size());
#pragma omp parallel for num_threads(m_threads) schedule(dynamic, 1)
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const std::size_t pair = m_overlapping[static_cast<std::size_t>(i)];
      const ScopedTimer timer(m_times_ns[pair]);
      collide(pair % m_muscles.size(), m_bones->object(pair / m_muscles.size()), m_results[pair], pairs[pair]);
    }
  }

  [[nodiscard]] std::span<const Nanoseconds> times() const override { return m_times_ns; }

  void collide_muscles(std::size_t first, std::size_t second, std::vector<TrianglePair>& pairs) override {
    pairs.clear();
    const DeformingModel<BoundingVolume>& one = *m_models[first];
    const DeformingModel<BoundingVolume>& other = *m_models[second];
    if (!one.finite() || !other.finite() || !one.object().getAABB().overlap(other.object().getAABB())) {
      return;
    }
    fcl::CollisionResultd result;
    collide(first, other.object(), result, pairs);
    for (TrianglePair& pair : pairs) {
      pair.other_triangle = m_muscles[second].triangles[static_cast<std::size_t>(pair.other_triangle)];
    }
  }

  [[nodiscard]] std::size_t bytes() const override {
    std::size_t sum = m_bones->bytes() + m_bone_model_bytes;
    for (const auto& model : m_models) sum += model->bytes();
    return sum;
  }

 private:
  /// Appends triangles of a muscle and, as the other's model counts them, of `other`. Several threads may be in here,
  /// each with a result and a list of its own.
  void collide(std::size_t muscle, const fcl::CollisionObjectd& other, fcl::CollisionResultd& result,
               std::vector<TrianglePair>& list) const {
    result.clear();
    fcl::collide(&m_models[muscle]->object(), &other, m_request, result);
    for (std::size_t i = 0; i < result.numContacts(); ++i) {
      // Only the indices: with boxes that are not oriented, o1 and o2 point to copies that FCL has deleted by now.
      const fcl::Contactd& contact = result.getContact(i);
      list.push_back({m_muscles[muscle].triangles[static_cast<std::size_t>(contact.b1)], static_cast<int>(contact.b2)});
    }
  }

  int m_threads;
  fcl::CollisionRequestd m_request;
  std::vector<MuscleSurface> m_muscles;
  std::vector<std::unique_ptr<DeformingModel<BoundingVolume>>> m_models;  ///< by muscle
  std::unique_ptr<BoneObjects> m_bones;
  // By bone, then muscle.
  std::vector<fcl::CollisionResultd> m_results;
  std::vector<Nanoseconds> m_times_ns;
  std::vector<std::size_t> m_near_bones;   ///< scratch memory
  std::vector<std::size_t> m_overlapping;  ///< pairs whose boxes do
  std::size_t m_bone_model_bytes = 0;
};

}  // namespace

std::unique_ptr<SurfaceCollider> make_surface_collider(const FclOptions& options, std::span<const Bone* const> bones,
                                                       std::vector<MuscleSurface> muscles, int threads) {
  return with_bounding_volume(options.bounding_volume, [&](auto volume) -> std::unique_ptr<SurfaceCollider> {
    return std::make_unique<FclSurfaceCollider<typename decltype(volume)::type>>(options, bones, std::move(muscles),
                                                                                 threads);
  });
}

}  // namespace musclebench

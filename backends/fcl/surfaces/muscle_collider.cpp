#include "backends/fcl/surfaces/muscle_collider.hpp"

#include <limits>

#include <fcl/narrowphase/collision.h>

#include "backends/fcl/surfaces/deforming_model.hpp"

namespace musclebench {

namespace {

template <typename BoundingVolume>
class FclMuscleCollider final : public MuscleCollider {
 public:
  FclMuscleCollider(const FclOptions& options, std::span<const MuscleSurface> muscles)
      : m_request(std::numeric_limits<std::size_t>::max()) {
    m_request.gjk_solver_type = to_fcl(options.narrow_phase);
    for (const MuscleSurface& muscle : muscles) {
      m_models.push_back(
          std::make_unique<DeformingModel<BoundingVolume>>(options, muscle.rest_positions, muscle.local_triangles));
    }
  }

  void update(std::size_t muscle, std::span<const Vec3> positions) override { m_models[muscle]->update(positions); }

  void collide(std::size_t first, std::size_t second, std::vector<IntersectingTriangles>& pairs) override {
    pairs.clear();
    DeformingModel<BoundingVolume>& one = *m_models[first];
    DeformingModel<BoundingVolume>& other = *m_models[second];
    if (!one.finite() || !other.finite() || !one.object().getAABB().overlap(other.object().getAABB())) {
      return;
    }
    fcl::CollisionResultd result;
    fcl::collide(&one.object(), &other.object(), m_request, result);
    for (std::size_t i = 0; i < result.numContacts(); ++i) {
      // Only the indices: with boxes that are not oriented, o1 and o2 point to copies that FCL has deleted by now.
      const fcl::Contactd& contact = result.getContact(i);
      pairs.push_back({static_cast<int>(contact.b1), static_cast<int>(contact.b2)});
    }
  }

  [[nodiscard]] std::size_t bytes() const override {
    std::size_t sum = 0;
    for (const auto& model : m_models) sum += model->bytes();
    return sum;
  }

 private:
  fcl::CollisionRequestd m_request;
  std::vector<std::unique_ptr<DeformingModel<BoundingVolume>>> m_models;
};

}  // namespace

std::unique_ptr<MuscleCollider> make_muscle_collider(const FclOptions& options,
                                                     std::span<const MuscleSurface> muscles) {
  return with_bounding_volume(options.bounding_volume, [&](auto volume) -> std::unique_ptr<MuscleCollider> {
    return std::make_unique<FclMuscleCollider<typename decltype(volume)::type>>(options, muscles);
  });
}

}  // namespace musclebench

#include "backends/bvh/bvh_backend.hpp"

#include "backends/bvh/exact_surface.hpp"
#include "backends/bvh/muscle_detector.hpp"
#include "core/clearance/cached_point_query.hpp"

namespace musclebench {

namespace {

class BvhBackend final : public CollisionBackend {
 public:
  explicit BvhBackend(bool clearance_cache) : m_uses_cache(clearance_cache) {}

  [[nodiscard]] Capabilities capabilities() const override {
    return {.has_cache = m_uses_cache, .steady_memory = true};
  }
  [[nodiscard]] AnswerBound answer_bound(int bone) const override {
    return {m_surfaces[static_cast<std::size_t>(bone)].touching_m(), 0};
  }

  [[nodiscard]] std::size_t structure_bytes() const override {
    std::size_t bytes = m_query.bytes();
    for (const ExactSurface& surface : m_surfaces) {
      bytes += surface.bytes();
    }
    return bytes;
  }

 private:
  void do_build() override {
    m_surfaces.clear();
    m_surfaces.reserve(bones().size());
    for (const Bone& bone : bones()) {
      m_surfaces.emplace_back(bone, threads());
    }
    m_query.reset(bones(), m_surfaces, muscle().vertices.size(), m_uses_cache, threads());
  }

  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    m_query.detect(poses(), positions, nodes, contacts);
  }

  bool m_uses_cache;
  std::vector<ExactSurface> m_surfaces;  ///< one a bone
  CachedPointQuery<ExactSurface> m_query;
};

}  // namespace

std::unique_ptr<CollisionBackend> make_bvh_backend(const Parameters& parameters) {
  return std::make_unique<BvhBackend>(uses_clearance_cache(parameters));
}

BackendEntry bvh_entry() {
  return {.name = "bvh",
          .help = "exact: closest point by a tree of boxes over each bone, signed robustly",
          .default_response = ResponseKind::project,
          .exact = true,
          .parameters = {clearance_cache_parameter()},
          .make = make_bvh_backend,
          .signed_distance = [](const Bone& bone, int threads) -> SignedDistance {
            const auto surface = std::make_shared<const ExactSurface>(bone, threads);
            return [surface](const Vec3& point) { return surface->signed_distance_m(point); };
          },
          .make_muscle_detector = make_bvh_muscle_detector};
}

}  // namespace musclebench

#include "backends/fcl/surfaces/muscle_detector.hpp"

#include <algorithm>
#include <utility>

#include "backends/fcl/fcl_options.hpp"
#include "backends/fcl/surfaces/met_triangles.hpp"
#include "backends/fcl/surfaces/surface_collider.hpp"
#include "core/base/input_error.hpp"
#include "core/distance/pseudo_normals.hpp"

namespace musclebench {

namespace {

class FclMuscleDetector final : public MuscleContactDetector {
 public:
  FclMuscleDetector(const FclOptions& options, const TouchingMuscles& muscles, int threads)
      : m_muscles(muscles),
        m_threads(threads),
        m_normals(muscles.mesh),
        m_found(muscles.pairs.size()),
        m_pair_times(no_times(muscles.pairs)) {
    std::vector<MuscleSurface> surfaces;
    for (const Body& body : muscles.bodies) {
      m_is_alone.push_back(muscles_beside(muscles.pairs, static_cast<int>(surfaces.size())).empty());
      surfaces.push_back(muscle_surface(muscles.mesh, body, "fcl: contact between muscles"));
    }
    for (std::size_t pair = 0; pair < muscles.pairs.size(); ++pair) {
      m_met.push_back(
          {MetTriangles(nodes_of(muscles.pairs[pair].first)), MetTriangles(nodes_of(muscles.pairs[pair].second))});
    }
    m_collider = make_surface_collider(options, {}, std::move(surfaces), threads);
  }

  void detect(std::span<const Vec3> positions, std::vector<MuscleContact>& contacts) override {
    contacts.clear();
    const auto bodies = static_cast<std::ptrdiff_t>(m_muscles.bodies.size());
#pragma omp parallel for num_threads(m_threads) schedule(dynamic, 1)
    for (std::ptrdiff_t i = 0; i < bodies; ++i) {
      if (!m_is_alone[static_cast<std::size_t>(i)]) m_collider->deform(static_cast<std::size_t>(i), positions);
    }
    const auto pairs = static_cast<std::ptrdiff_t>(m_muscles.pairs.size());
#pragma omp parallel for num_threads(m_threads) schedule(dynamic, 1)
    for (std::ptrdiff_t i = 0; i < pairs; ++i) {
      collide_pair(static_cast<std::size_t>(i), positions);
    }
    for (const std::vector<MuscleContact>& found : m_found) {
      contacts.insert(contacts.end(), found.begin(), found.end());
    }
    std::sort(contacts.begin(), contacts.end(), [](const MuscleContact& a, const MuscleContact& b) {
      return std::pair(a.node, a.muscle) < std::pair(b.node, b.muscle);
    });
  }

  [[nodiscard]] std::span<const PairTime> pair_times() const override { return m_pair_times; }

  [[nodiscard]] std::size_t structure_bytes() const override {
    std::size_t sum = m_collider->bytes() + m_normals.bytes();
    for (const auto& [first, second] : m_met) sum += first.bytes() + second.bytes();
    return sum;
  }

 private:
  [[nodiscard]] const Body& body(int muscle) const { return m_muscles.bodies[static_cast<std::size_t>(muscle)]; }
  [[nodiscard]] std::size_t nodes_of(int muscle) const {
    return static_cast<std::size_t>(body(muscle).last_node - body(muscle).first_node);
  }

  void collide_pair(std::size_t index, std::span<const Vec3> positions) {
    m_pair_times[index].detect_ns = 0;
    const ScopedTimer timer(m_pair_times[index].detect_ns);
    const MusclePair& pair = m_muscles.pairs[index];
    std::vector<TrianglePair> met;
    m_collider->collide_muscles(static_cast<std::size_t>(pair.first), static_cast<std::size_t>(pair.second), met);
    auto& [met_by_first, met_by_second] = m_met[index];
    met_by_first.start_round();
    met_by_second.start_round();
    for (const auto& [of_first, of_second] : met) {
      meet(pair.first, of_first, of_second, positions, met_by_first);
      meet(pair.second, of_second, of_first, positions, met_by_second);
    }
    m_found[index].clear();
    append(pair.first, pair.second, positions, met_by_first, m_found[index]);
    append(pair.second, pair.first, positions, met_by_second, m_found[index]);
  }

  /// The nodes of `triangle`, which is one of `muscle`, meet `other`.
  void meet(int muscle, int triangle, int other, std::span<const Vec3> positions, MetTriangles& met) const {
    const auto [a, b, c] = corners_of(other, positions);
    for (const int node : m_muscles.mesh.triangles[static_cast<std::size_t>(triangle)]) {
      met.meet(
          node - body(muscle).first_node, [&] { return positions[static_cast<std::size_t>(node)]; }, other, a, b, c);
    }
  }

  [[nodiscard]] std::array<Vec3, 3> corners_of(int triangle, std::span<const Vec3> positions) const {
    const auto& [a, b, c] = m_muscles.mesh.triangles[static_cast<std::size_t>(triangle)];
    return {positions[static_cast<std::size_t>(a)], positions[static_cast<std::size_t>(b)],
            positions[static_cast<std::size_t>(c)]};
  }

  void append(int muscle, int other, std::span<const Vec3> positions, const MetTriangles& met,
              std::vector<MuscleContact>& found) const {
    for (int node = body(muscle).first_node; node < body(muscle).last_node; ++node) {
      const MetTriangles::Closest* closest = met.find(node - body(muscle).first_node);
      if (closest == nullptr || !(closest->found.squared_distance_m2 > 0)) {
        continue;
      }
      const Vec3 outwards = m_normals.at(positions, closest->triangle, closest->found.feature);
      if (outwards.dot(closest->point - closest->found.point) < 0) {
        found.push_back(muscle_contact_at(node, other, closest->point, closest->triangle,
                                          corners_of(closest->triangle, positions), closest->found));
      }
    }
  }

  TouchingMuscles m_muscles;
  [[maybe_unused]] int m_threads;
  MovingPseudoNormals m_normals;
  std::vector<bool> m_is_alone;  ///< by muscle: touches no other
  std::unique_ptr<SurfaceCollider> m_collider;
  std::vector<std::pair<MetTriangles, MetTriangles>> m_met;  ///< by pair, of its first and its second muscle
  std::vector<std::vector<MuscleContact>> m_found;           ///< by pair
  std::vector<PairTime> m_pair_times;
};

}  // namespace

std::unique_ptr<MuscleContactDetector> make_fcl_muscle_detector(const Parameters& parameters,
                                                                const TouchingMuscles& muscles, int threads) {
  FclOptions options = fcl_options(parameters);
  if (options.query != Query::surfaces) {
    throw InputError("fcl: query",
                     "queries single nodes in a tree that never deforms; contact between muscles needs "
                     "query = surfaces");
  }
  if (options.broad_phase != FclOptions{}.broad_phase) {
    throw InputError("fcl: manager", "finds the bones near a muscle; leave it out between muscles");
  }
  options.broad_phase = BroadPhase::none;  // there are no bones
  return std::make_unique<FclMuscleDetector>(options, muscles, threads);
}

}  // namespace musclebench

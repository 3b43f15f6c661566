#include "backends/embree/muscle_detector.hpp"

#include <cmath>

#include "backends/embree/embree_scene.hpp"
#include "core/clearance/clearance_cache.hpp"
#include "core/clearance/deforming_structure.hpp"

namespace musclebench {

namespace {

/// More than the relative rounding errors of the lengths that a clearance is made of.
constexpr double length_rounding = 1e-9;

class RefittedScene final : public DeformingStructure {
 public:
  RefittedScene(const TriangleMesh& mesh, const Body& body, int rays)
      : m_first_triangle(static_cast<int>(body.first_triangle)),
        m_scene(mesh, std::span(mesh.triangles).subspan(body.first_triangle, body.last_triangle - body.first_triangle),
                {.rays = rays, .deforms = true}) {}

  void update(std::span<const Vec3> positions, int /*threads*/) override { m_scene.update(positions); }

  [[nodiscard]] MuscleAnswer query(const Vec3& point, const MuscleQuery& wanted, int& guess) const override {
    if (!point.allFinite()) return {};
    const EmbreeClosest closest = m_scene.closest(point, guess < 0 ? -1 : guess - m_first_triangle, wanted.enough_m);
    if (closest.triangle < 0) return {wanted.enough_m};
    const double distance_m = std::sqrt(closest.on_triangle.squared_distance_m2);
    guess = m_first_triangle + closest.triangle;
    const bool is_free = distance_m <= wanted.touching_m ||
                         distance_m * (1 - length_rounding) > wanted.excess_travel_m || !m_scene.is_inside(point);
    if (is_free) return {distance_m};
    return {0, guess, closest.on_triangle};
  }

  [[nodiscard]] std::size_t bytes() const override { return m_scene.bytes(); }

 private:
  int m_first_triangle;
  EmbreeScene m_scene;
};

}  // namespace

std::unique_ptr<MuscleContactDetector> make_embree_muscle_detector(const Parameters& parameters,
                                                                   const TouchingMuscles& muscles, int threads) {
  return make_point_muscle_detector(
      {.has_cache = uses_clearance_cache(parameters),
       .build = [rays = static_cast<int>(parameters.integer("rays"))](
                    const TriangleMesh& mesh,
                    const Body& body) { return std::make_unique<RefittedScene>(mesh, body, rays); }},
      muscles, threads);
}

}  // namespace musclebench

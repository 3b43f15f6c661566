#include "backends/bvh/muscle_detector.hpp"

#include "core/bvh/moving_surface_tree.hpp"
#include "core/clearance/clearance_cache.hpp"
#include "core/clearance/deforming_structure.hpp"

namespace musclebench {

namespace {

/// More than the relative rounding errors of the lengths that a clearance is made of.
constexpr double rounding = 1e-9;

class RefittedTree final : public DeformingStructure {
 public:
  RefittedTree(const TriangleMesh& mesh, const Body& body) : m_tree(mesh, body) {}

  void update(std::span<const Vec3> positions, int threads) override { m_tree.update(positions, threads); }

  [[nodiscard]] MuscleAnswer query(const Vec3& point, const MuscleQuery& wanted, int& guess) const override {
    if (const double box_m = m_tree.box_distance_m(point); box_m > 0) {
      return {box_m};
    }
    const ClosestPoint closest = m_tree.closest_point(point, guess, wanted.enough_m);
    if (closest.triangle < 0) {
      return {point.allFinite() ? wanted.enough_m : 0};
    }
    guess = closest.triangle;
    const bool is_free = closest.distance_m <= wanted.touching_m ||
                         closest.distance_m * (1 - rounding) > wanted.excess_travel_m ||
                         m_tree.winding_number(point) <= 0;
    if (is_free) {
      return {closest.distance_m};
    }
    return {0, closest.triangle, {closest.point, closest.distance_m * closest.distance_m, closest.feature}};
  }

  [[nodiscard]] std::size_t bytes() const override { return m_tree.bytes(); }

 private:
  MovingSurfaceTree m_tree;
};

}  // namespace

std::unique_ptr<MuscleContactDetector> make_bvh_muscle_detector(const Parameters& parameters,
                                                                const TouchingMuscles& muscles, int threads) {
  return make_point_muscle_detector(
      {.has_cache = uses_clearance_cache(parameters),
       .build = [](const TriangleMesh& mesh, const Body& body) { return std::make_unique<RefittedTree>(mesh, body); }},
      muscles, threads);
}

}  // namespace musclebench

#include "backends/brute_force/muscle_detector.hpp"

#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "core/clearance/deforming_structure.hpp"
#include "core/distance/triangle_distance.hpp"
#include "core/distance/winding_number.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

class AllMovingTriangles final : public DeformingStructure {
 public:
  AllMovingTriangles(const TriangleMesh& mesh, Body body) : m_mesh(mesh), m_body(std::move(body)) {}

  void update(std::span<const Vec3> positions, int /*threads*/) override {
    m_positions = positions;
    m_box = bounding_box(positions.subspan(static_cast<std::size_t>(m_body.first_node),
                                           static_cast<std::size_t>(m_body.last_node - m_body.first_node)));
  }

  [[nodiscard]] MuscleAnswer query(const Vec3& point, const MuscleQuery& wanted, int& /*guess*/) const override {
    if (!m_box.contains(point)) {
      return {m_box.exteriorDistance(point)};
    }
    MuscleAnswer nearest;
    nearest.closest.squared_distance_m2 = std::numeric_limits<double>::infinity();
    for (std::size_t t = m_body.first_triangle; t < m_body.last_triangle; ++t) {
      const auto& [a, b, c] = m_mesh.triangles[t];
      const Vec3& pa = m_positions[static_cast<std::size_t>(a)];
      const Vec3& pb = m_positions[static_cast<std::size_t>(b)];
      const Vec3& pc = m_positions[static_cast<std::size_t>(c)];
      const ClosestOnTriangle found = closest_on_triangle(point, pa, pb, pc);
      if (found.squared_distance_m2 < nearest.closest.squared_distance_m2) {
        nearest.closest = found;
        nearest.triangle = static_cast<int>(t);
      }
    }
    const std::span<const Triangle> own =
        std::span(m_mesh.triangles).subspan(m_body.first_triangle, m_body.last_triangle - m_body.first_triangle);
    const bool is_inside = winding_number(own, m_positions, point) > 0.5;
    if (!is_inside || !(nearest.closest.squared_distance_m2 > wanted.touching_m * wanted.touching_m)) {
      return {std::sqrt(nearest.closest.squared_distance_m2)};
    }
    return nearest;
  }

  [[nodiscard]] std::size_t bytes() const override { return 0; }

 private:
  const TriangleMesh& m_mesh;
  Body m_body;
  std::span<const Vec3> m_positions;
  Eigen::AlignedBox3d m_box;  ///< beyond it nothing is inside
};

}  // namespace

std::unique_ptr<MuscleContactDetector> make_brute_force_muscle_detector(const Parameters& /*parameters*/,
                                                                        const TouchingMuscles& muscles, int threads) {
  return make_point_muscle_detector(
      {.build = [](const TriangleMesh& mesh,
                   const Body& body) { return std::make_unique<AllMovingTriangles>(mesh, body); }},
      muscles, threads);
}

}  // namespace musclebench

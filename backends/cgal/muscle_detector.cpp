#include "backends/cgal/muscle_detector.hpp"

#include <boost/iterator/function_output_iterator.hpp>
#include <cmath>
#include <optional>

#include "backends/cgal/cgal_mesh.hpp"
#include "core/clearance/clearance_cache.hpp"
#include "core/clearance/deforming_structure.hpp"
#include "core/distance/triangle_distance.hpp"

namespace musclebench {

namespace {

/// More than the relative rounding errors of the lengths that a clearance is made of.
constexpr double length_rounding = 1e-9;

class RebuiltTree final : public DeformingStructure {
 public:
  RebuiltTree(const TriangleMesh& mesh, const Body& body)
      : m_first_triangle(static_cast<int>(body.first_triangle)),
        m_triangles(std::span(mesh.triangles).subspan(body.first_triangle, body.last_triangle - body.first_triangle)),
        m_surface(to_cgal(mesh.vertices, m_triangles)) {}

  void update(std::span<const Vec3> positions, int /*threads*/) override {
    m_positions = positions;
    for (const CgalMesh::Vertex_index vertex : m_surface.mesh.vertices()) {
      m_surface.mesh.point(vertex) =
          to_cgal(positions[static_cast<std::size_t>(m_surface.vertex_of[static_cast<std::size_t>(vertex)])]);
    }
    m_side.reset();
    m_tree.rebuild(faces(m_surface.mesh).first, faces(m_surface.mesh).second, m_surface.mesh);
    // Hints serve as well, and a search tree would have to be built in each step.
    m_tree.do_not_accelerate_distance_queries();
    m_tree.build();
    m_side.emplace(m_tree);
  }

  [[nodiscard]] MuscleAnswer query(const Vec3& point, const MuscleQuery& wanted, int& guess) const override {
    if (!point.allFinite()) return {};
    const CgalPoint query = to_cgal(point);
    const auto near = static_cast<CgalMesh::size_type>(guess < 0 ? 0 : guess - m_first_triangle);
    const CgalMesh::Face_index face(near);
    const CgalTree::Point_and_primitive_id hint{
        m_surface.mesh.point(m_surface.mesh.target(m_surface.mesh.halfedge(face))), face};
    const auto found = static_cast<int>(m_tree.closest_point_and_primitive(query, hint).second.idx());
    guess = m_first_triangle + found;
    const ClosestOnTriangle closest = on_triangle(point, found);
    const double distance_m = std::sqrt(closest.squared_distance_m2);
    const bool is_free = distance_m <= wanted.touching_m ||
                         distance_m * (1 - length_rounding) > wanted.excess_travel_m ||
                         (*m_side)(query) != CGAL::ON_BOUNDED_SIDE;
    if (is_free) return {distance_m};
    return first_of_ties(point, {0, guess, closest}, distance_m);
  }

  [[nodiscard]] std::size_t bytes() const override { return sizeof(*this) + cgal_bytes(m_surface.mesh, false); }

 private:
  /// CGAL tells any of several triangles at the same distance. What a contact moves may not depend on the order in
  /// which its tree was built.
  [[nodiscard]] MuscleAnswer first_of_ties(const Vec3& point, MuscleAnswer first, double distance_m) const {
    const Vec3 reach = Vec3::Constant(distance_m * (1 + length_rounding));
    const Vec3 low = point - reach;
    const Vec3 high = point + reach;
    const auto look = [&](const CgalMesh::Face_index& face) {
      const auto triangle = static_cast<int>(face.idx());
      const ClosestOnTriangle other = on_triangle(point, triangle);
      const double squared = first.closest.squared_distance_m2;
      const bool is_earlier = m_first_triangle + triangle < first.triangle;
      if (other.squared_distance_m2 < squared || (other.squared_distance_m2 == squared && is_earlier)) {
        first = {0, m_first_triangle + triangle, other};
      }
    };
    m_tree.all_intersected_primitives(CGAL::Bbox_3(low.x(), low.y(), low.z(), high.x(), high.y(), high.z()),
                                      boost::make_function_output_iterator(look));
    return first;
  }

  [[nodiscard]] ClosestOnTriangle on_triangle(const Vec3& point, int triangle) const {
    const auto& [a, b, c] = m_triangles[static_cast<std::size_t>(triangle)];
    return closest_on_triangle(point, m_positions[static_cast<std::size_t>(a)],
                               m_positions[static_cast<std::size_t>(b)], m_positions[static_cast<std::size_t>(c)]);
  }

  int m_first_triangle;
  std::span<const Triangle> m_triangles;
  CgalSurface m_surface;
  std::span<const Vec3> m_positions;
  CgalTree m_tree;
  std::optional<CgalSide> m_side;
};

}  // namespace

std::unique_ptr<MuscleContactDetector> make_cgal_muscle_detector(const Parameters& parameters,
                                                                 const TouchingMuscles& muscles, int threads) {
  return make_point_muscle_detector(
      {.has_cache = uses_clearance_cache(parameters),
       .build = [](const TriangleMesh& mesh, const Body& body) -> std::unique_ptr<DeformingStructure> {
         return std::make_unique<RebuiltTree>(mesh, body);
       }},
      muscles, threads);
}

}  // namespace musclebench

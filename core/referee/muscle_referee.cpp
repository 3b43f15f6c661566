#include "core/referee/muscle_referee.hpp"

#include <cmath>
#include <utility>

#include "core/base/input_error.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

MuscleReferee::MuscleReferee(const TriangleMesh& mesh, JudgedMuscles muscles) : m_muscles(std::move(muscles)) {
  for (const Body& body : m_muscles.bodies) {
    if (body.first_triangle == body.last_triangle) {
      throw InputError("muscle " + body.name, "its surface has no triangles; give a mesh with faces");
    }
    TriangleMesh own{{mesh.vertices.begin() + body.first_node, mesh.vertices.begin() + body.last_node}, {}};
    for (std::size_t t = body.first_triangle; t < body.last_triangle; ++t) {
      const auto& [a, b, c] = mesh.triangles[t];
      own.triangles.push_back({a - body.first_node, b - body.first_node, c - body.first_node});
    }
    RefereeTree tree(own);
    const double touching_m = touching_distance_m(own);
    m_surfaces.push_back({std::move(own.triangles), std::move(tree), touching_m});
  }
}

void MuscleReferee::judge(std::span<const Vec3> positions, std::vector<Contact>& truth) {
  truth.clear();
  m_work = 0;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (std::size_t i = 0; i < m_surfaces.size(); ++i) {
    const Body& body = m_muscles.bodies[i];
    const auto own = positions.subspan(static_cast<std::size_t>(body.first_node),
                                       static_cast<std::size_t>(body.last_node - body.first_node));
    m_surfaces[i].tree.refit(m_surfaces[i].triangles, own);
    boxes.push_back(bounding_box(own));
  }
  for (std::size_t i = 0; i < m_surfaces.size(); ++i) {
    for (int node = m_muscles.bodies[i].first_node; node < m_muscles.bodies[i].last_node; ++node) {
      const Vec3& position = positions[static_cast<std::size_t>(node)];
      for (const int other : m_muscles.beside[i]) {
        const Surface& surface = m_surfaces[static_cast<std::size_t>(other)];
        if (!boxes[static_cast<std::size_t>(other)].contains(position)) {
          continue;
        }
        const Vec3 point = position - surface.tree.centre_m();
        if (!(surface.tree.winding_number(point, &m_work) > 0.5)) {
          continue;
        }
        const ClosestSurfacePoint closest = surface.tree.closest(point, -1, &m_work);
        const double depth_m = std::sqrt(closest.squared_distance_m2);
        if (depth_m > surface.touching_m) {
          truth.push_back({node, other, depth_m, (closest.point_m - point) / depth_m});
        }
      }
    }
  }
}

SurfaceDistance MuscleReferee::distance(int muscle, const Vec3& point_m) const {
  const Surface& surface = m_surfaces[static_cast<std::size_t>(muscle)];
  const Vec3 point = point_m - surface.tree.centre_m();
  const ClosestSurfacePoint closest = surface.tree.closest(point);
  const double distance_m = std::sqrt(closest.squared_distance_m2);
  const bool is_inside = surface.tree.winding_number(point) > 0.5;
  SurfaceDistance found{is_inside ? -distance_m : distance_m, closest.point_m + surface.tree.centre_m(),
                        surface.tree.face_normal(closest.slot)};
  if (distance_m > surface.touching_m) {
    found.normal = (is_inside ? 1 : -1) * (closest.point_m - point) / distance_m;
  }
  return found;
}

}  // namespace musclebench

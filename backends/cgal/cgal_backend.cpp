#include <CGAL/version.h>
#include <array>
#include <boost/iterator/function_output_iterator.hpp>
#include <cstddef>
#include <memory>
#include <vector>

#include "backends/cgal/cgal_mesh.hpp"
#include "backends/cgal/muscle_detector.hpp"
#include "core/clearance/located_triangles.hpp"
#include "core/clearance/point_backend.hpp"
#include "core/contact/backend_entry.hpp"

namespace musclebench {

namespace {

class CgalBone {
 public:
  CgalBone(const Bone& bone, bool starts_warm, bool accelerates)
      : m_mesh(to_cgal(bone.surface.mesh.vertices, bone.surface.mesh.triangles).mesh),
        m_tree(faces(m_mesh).first, faces(m_mesh).second, m_mesh),
        m_touching_m(touching_distance_m(bone.surface.mesh)),
        m_starts_warm(starts_warm),
        m_accelerates(accelerates) {
    m_tree.build();
    if (accelerates) {
      m_tree.accelerate_distance_queries();
    } else {
      m_tree.do_not_accelerate_distance_queries();
    }
    m_side = std::make_unique<CgalSide>(m_tree);
  }
  CgalBone(const CgalBone&) = delete;
  CgalBone& operator=(const CgalBone&) = delete;

  /// Sides are exact, closest points are rounded.
  [[nodiscard]] AnswerBound answer_bound() const { return {m_touching_m, m_touching_m}; }
  [[nodiscard]] std::size_t bytes() const { return sizeof(*this) + cgal_bytes(m_mesh, m_accelerates); }

  [[nodiscard]] int closest(const Vec3& point, int near) const {
    const CgalPoint query = to_cgal(point);
    const auto found = near >= 0 && m_starts_warm ? m_tree.closest_point_and_primitive(query, hint(near))
                                                  : m_tree.closest_point_and_primitive(query);
    return static_cast<int>(found.second.idx());
  }
  void list_within(const Vec3& point, double radius_m, ListedTriangles& list) const {
    const Vec3 low = point.array() - radius_m;
    const Vec3 high = point.array() + radius_m;
    const CGAL::Bbox_3 box(low.x(), low.y(), low.z(), high.x(), high.y(), high.z());
    m_tree.all_intersected_primitives(box, boost::make_function_output_iterator([&](const CgalMesh::Face_index& face) {
                                        list.add(static_cast<int>(face.idx()));
                                      }));
  }
  [[nodiscard]] bool is_inside(const Vec3& point) const { return (*m_side)(to_cgal(point)) == CGAL::ON_BOUNDED_SIDE; }

 private:
  [[nodiscard]] CgalTree::Point_and_primitive_id hint(int face) const {
    const CgalMesh::Face_index index(static_cast<CgalMesh::size_type>(face));
    return {m_mesh.point(m_mesh.target(m_mesh.halfedge(index))), index};
  }

  CgalMesh m_mesh;
  CgalTree m_tree;
  std::unique_ptr<CgalSide> m_side;
  double m_touching_m;
  bool m_starts_warm;
  bool m_accelerates;
};

auto bone_maker(bool starts_warm, bool accelerates) {
  return [starts_warm, accelerates](const Bone& bone) {
    return std::make_unique<const CgalBone>(bone, starts_warm, accelerates);
  };
}

auto bone_maker(const Parameters& parameters) {
  return bone_maker(parameters.flag("warm_start"), parameters.flag("accelerate"));
}

/// A second judge of exact backends: predicates are exact, and the code is not ours.
SignedDistance cgal_signed_distance(const Bone& bone, int threads) {
  return [queries = queries_on_triangles(bone_maker(true, true))(bone, threads)](const Vec3& point) {
    return queries->locate(point, -1).signed_distance_m;
  };
}

std::unique_ptr<CollisionBackend> make_cgal_backend(const Parameters& parameters) {
  return make_point_backend({.capabilities = {.has_cache = uses_clearance_cache(parameters)},
                             .nodes_a_batch = 64,
                             .contact_reach_m = [](const Bone& bone) { return touching_distance_m(bone.surface.mesh); },
                             .build = build_on_triangles(parameters, bone_maker(parameters))});
}

}  // namespace

// How it is driven follows CGAL's manual, "3D Fast Intersection and Distance Computation (AABB Tree)", sections on
// performance and hints, and `Side_of_triangle_mesh` of "Polygon Mesh Processing".
BackendEntry cgal_entry() {
  return {.name = "cgal",
          .help = "closest point by CGAL's AABB tree over each bone, side by exact predicates",
          .implementation = "CGAL " CGAL_VERSION_STR ", GPL-3.0-or-later (so is a program built with it)",
          .default_response = ResponseKind::project,
          .parameters = {parameter::flag({.name = "accelerate",
                                          .default_value = true,
                                          .help = "build a search tree of points that gives each query a first guess"}),
                         parameter::flag({.name = "warm_start",
                                          .default_value = true,
                                          .help = "begin with the triangle that was closest to the node last"}),
                         cull_parameter(), clearance_cache_parameter()},
          .make = make_cgal_backend,
          .signed_distance = cgal_signed_distance,
          .make_muscle_detector = make_cgal_muscle_detector,
          .make_surface_queries = [](const Parameters& parameters, std::span<const Bone> /*bones*/) {
            return queries_on_triangles(bone_maker(parameters));
          }};
}

}  // namespace musclebench

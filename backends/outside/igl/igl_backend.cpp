#include <cmath>
#include <cstddef>
#include <igl/AABB.h>
#include <igl/fast_winding_number.h>
#include <igl/per_edge_normals.h>
#include <igl/per_face_normals.h>
#include <igl/per_vertex_normals.h>
#include <igl/pseudonormal_test.h>
#include <limits>
#include <memory>
#include <optional>

#include <Eigen/Core>

#include "core/clearance/located_nodes.hpp"
#include "core/clearance/point_backend.hpp"
#include "core/contact/backend_entry.hpp"

namespace musclebench {

namespace {

using IglPoint = Eigen::RowVector3d;

/// libigl compares distances with constants, which rounding would exceed far from the origin: the surface is kept
/// relative to its middle.
class IglBone {
 public:
  IglBone(const Bone& bone, bool by_winding, bool starts_warm)
      : m_middle(bounding_box(bone.surface.mesh.vertices).center()),
        m_size_m(bounding_box(bone.surface.mesh.vertices).diagonal().norm()),
        m_touching_m(touching_distance_m(bone.surface.mesh)),
        m_is_closed(is_closed(bone.surface.mesh)),
        m_is_clean(bone.surface.clean),
        m_by_winding(by_winding),
        m_starts_warm(starts_warm) {
    const TriangleMesh& mesh = bone.surface.mesh;
    m_vertices.resize(static_cast<Eigen::Index>(mesh.vertices.size()), 3);
    for (Eigen::Index i = 0; i < m_vertices.rows(); ++i) {
      m_vertices.row(i) = mesh.vertices[static_cast<std::size_t>(i)] - m_middle;
    }
    m_triangles.resize(static_cast<Eigen::Index>(mesh.triangles.size()), 3);
    for (Eigen::Index i = 0; i < m_triangles.rows(); ++i) {
      m_triangles.row(i) = Eigen::RowVector3i::Map(mesh.triangles[static_cast<std::size_t>(i)].data());
    }
    m_tree.init(m_vertices, m_triangles);
    if (m_by_winding) {
      igl::fast_winding_number(m_vertices.cast<float>().eval(), m_triangles, expansion_order, m_windings);
      return;
    }
    igl::per_face_normals(m_vertices, m_triangles, m_face_normals);
    igl::per_vertex_normals(m_vertices, m_triangles, igl::PER_VERTEX_NORMALS_WEIGHTING_TYPE_ANGLE, m_face_normals,
                            m_vertex_normals);
    Eigen::MatrixXi edges;
    igl::per_edge_normals(m_vertices, m_triangles, igl::PER_EDGE_NORMALS_WEIGHTING_TYPE_UNIFORM, m_face_normals,
                          m_edge_normals, edges, m_edges_of_triangles);
  }
  IglBone(const IglBone&) = delete;
  IglBone& operator=(const IglBone&) = delete;

  /// Closest points are exact. The winding number is of single precision, and normals tell the side of clean surfaces.
  [[nodiscard]] AnswerBound answer_bound() const {
    if (m_by_winding) return {m_touching_m + rounding_m(), m_touching_m + rounding_m(), rounding_m()};
    const double side_m = m_is_clean ? m_touching_m : std::numeric_limits<double>::infinity();
    return {side_m, side_m};
  }
  /// By the sizes of what libigl keeps: a tree of one node a triangle and one a split, and the matrices. A node of
  /// winding numbers has four children and a box of coefficients of each; there is about one for three triangles.
  [[nodiscard]] std::size_t bytes() const {
    const auto triangles = static_cast<std::size_t>(m_triangles.rows());
    const Eigen::Index numbers =
        m_vertices.size() + m_face_normals.size() + m_vertex_normals.size() + m_edge_normals.size();
    constexpr std::size_t of_windings = 4 * (sizeof(int) + 40 * sizeof(float)) / 3 + 3 * sizeof(int);
    return sizeof(*this) + static_cast<std::size_t>(numbers) * sizeof(double) +
           static_cast<std::size_t>(m_triangles.size() + m_edges_of_triangles.size()) * sizeof(int) +
           2 * triangles * sizeof(m_tree) +
           (m_by_winding ? triangles * of_windings + m_windings.U.size() * 3 * sizeof(float) : 0);
  }
  [[nodiscard]] static std::optional<StructureError> error() { return std::nullopt; }
  [[nodiscard]] const IglBone& session() const { return *this; }

  [[nodiscard]] LocatedPoint locate(const Vec3& point, int& near) const {
    const IglPoint query = (point - m_middle).transpose();
    IglPoint closest = IglPoint::Zero();
    int triangle = -1;
    const double squared_m2 =
        m_tree.squared_distance(m_vertices, m_triangles, query, reach_m2(query, near), triangle, closest);
    near = triangle;
    const double distance_m = std::sqrt(squared_m2);
    if (distance_m > m_touching_m && is_inside(query, triangle, closest)) {
      return {.inside = true, .depth_m = distance_m, .outward = (closest - query).transpose() / distance_m};
    }
    return {.clearance_m = m_is_closed ? distance_m : 0};
  }

 private:
  static constexpr int expansion_order = 2;  ///< of the winding number, and
  static constexpr float accuracy = 2;       ///< how near it is summed: both as in libigl's signed distance

  [[nodiscard]] double rounding_m() const {
    constexpr double units = 16;
    return units * static_cast<double>(std::numeric_limits<float>::epsilon()) * m_size_m;
  }
  /// No triangle need be looked at that is farther than a corner of the last one.
  [[nodiscard]] double reach_m2(const IglPoint& query, int near) const {
    constexpr double more_than_rounding = 1 + 1e-9;
    if (near < 0 || !m_starts_warm) return std::numeric_limits<double>::infinity();
    return more_than_rounding * (m_vertices.row(m_triangles(near, 0)) - query).squaredNorm();
  }
  [[nodiscard]] bool is_inside(const IglPoint& query, int triangle, IglPoint& closest) const {
    if (m_by_winding) return igl::fast_winding_number(m_windings, accuracy, query.cast<float>().eval()) > 0.5F;
    double side = 0;
    IglPoint normal;
    igl::pseudonormal_test(m_vertices, m_triangles, m_face_normals, m_vertex_normals, m_edge_normals,
                           m_edges_of_triangles, query, triangle, closest, side, normal);
    return side < 0;
  }

  Vec3 m_middle;
  double m_size_m;
  double m_touching_m;
  bool m_is_closed;
  bool m_is_clean;
  bool m_by_winding;
  bool m_starts_warm;
  Eigen::MatrixXd m_vertices;
  Eigen::MatrixXi m_triangles;
  igl::AABB<Eigen::MatrixXd, 3> m_tree;
  igl::FastWindingNumberBVH m_windings;
  Eigen::MatrixXd m_face_normals;
  Eigen::MatrixXd m_vertex_normals;
  Eigen::MatrixXd m_edge_normals;
  Eigen::VectorXi m_edges_of_triangles;
};

std::unique_ptr<CollisionBackend> make_igl_backend(const Parameters& parameters) {
  return make_point_backend(
      {.capabilities = {.has_cache = uses_clearance_cache(parameters)},
       .nodes_a_batch = 64,
       .contact_reach_m =
           [](const Bone& bone) { return 1e-5 * bounding_box(bone.surface.mesh.vertices).diagonal().norm(); },
       .build = build_located(parameters, [by_winding = parameters.word("side") == "winding_number",
                                           starts_warm = parameters.flag("warm_start")](
                                              const Bone& bone, int /*threads*/, const ShareReport& /*report*/) {
         return std::make_unique<const IglBone>(bone, by_winding, starts_warm);
       })});
}

}  // namespace

// How it is driven follows libigl's tutorial, chapter "Signed distances", and the comments of its signed_distance.h.
BackendEntry igl_entry() {
  return {.name = "igl",
          .help = "closest point by libigl's AABB tree over each bone, side by its fast winding number",
          .implementation = "libigl, MPL-2.0",
          .default_response = ResponseKind::project,
          .parameters = {parameter::choice({.name = "side",
                                            .choices = {"winding_number", "pseudo_normal"},
                                            .help = "what tells the side of a node. pseudo_normal is faster, and wrong "
                                                    "where a surface is not clean"}),
                         parameter::flag({.name = "warm_start",
                                          .default_value = true,
                                          .help = "search no farther than the triangle that was closest last"}),
                         cull_parameter(), clearance_cache_parameter()},
          .make = make_igl_backend};
}

}  // namespace musclebench

#pragma once

#include <numbers>
#include <optional>

#include "core/bvh/triangle_bvh.hpp"

namespace musclebench {

/// The edges and vertices where a surface turns sharply by its mesh: edges between two triangles whose
/// normals are more than `turn_rad` apart, edges of one or of more than two triangles (rims, fins, branches), vertices
/// of which two triangles are more than `turn_rad` apart.
///
/// A point is sharp within one mean edge length of such a feature: below that length a mesh says nothing about the
/// shape that it stands for; but within no more than 1/100 of the surface's diagonal, so that a box of twelve triangles
/// is flat between its edges. All of it scales with the mesh. A finer mesh of a rounded edge turns less from triangle
/// to triangle: it is sharp where the rounding is narrower than about two of its edges.
class SharpFeatures {
 public:
  static constexpr double default_turn_rad = std::numbers::pi / 6;

  /// `mesh` has triangles and need not outlive this.
  explicit SharpFeatures(const TriangleMesh& mesh, double turn_rad = default_turn_rad);

  /// Whether `point`, which lies on the surface, is sharp.
  [[nodiscard]] bool near(const Vec3& point) const {
    return m_features && m_features->closest_point(point, m_radius_m).has_value();
  }

  [[nodiscard]] double radius_m() const { return m_radius_m; }
  [[nodiscard]] int edges() const { return m_edges; }
  [[nodiscard]] int vertices() const { return m_vertices; }

 private:
  std::optional<TriangleBvh> m_features;  ///< edges and vertices as triangles without area; none: nothing is sharp
  double m_radius_m = 0;
  int m_edges = 0;
  int m_vertices = 0;
};

}  // namespace musclebench

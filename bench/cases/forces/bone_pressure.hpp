#pragma once

#include <span>
#include <vector>

#include "bench/cases/forces/facing_areas.hpp"
#include "core/bvh/triangle_bvh.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// What muscles do to the vertices of one bone, in its frame.
struct VertexLoads {
  std::vector<Vec3> forces_n;
  std::vector<double> pressures_pa;  ///< of each muscle the force over the area that faces it; their sum
};

/// Carries pushes from the nodes of muscles over to the vertices of a bone.
///
/// The push of a node is spread over those points of the bone that the triangles about the node cover, each by the
/// node's weight at its closest point. So pushes of nodes that are far apart do not become peaks on a fine bone, and
/// all forces add up to those on the muscle. A bone that is coarser than the muscle tells means over its triangles.
class BonePressure {
 public:
  /// `bone` outlives this. Builds a tree over it.
  explicit BonePressure(const TriangleMesh& bone);

  /// Adds what one surface does to the bone. `positions_m` and `pushes_n` (on the surface, along contacts' normals) are
  /// by node and in the bone's frame.
  void add(std::span<const Triangle> triangles, std::span<const Vec3> positions_m, std::span<const Vec3> pushes_n);

  [[nodiscard]] const VertexLoads& loads() const { return m_loads; }

 private:
  const TriangleMesh& m_bone;
  TriangleBvh m_tree;
  FacingAreas m_areas;
  VertexLoads m_loads;
};

}  // namespace musclebench

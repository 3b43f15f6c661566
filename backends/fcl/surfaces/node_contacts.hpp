#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "backends/fcl/surfaces/met_triangles.hpp"
#include "backends/fcl/surfaces/surface_collider.hpp"
#include "core/distance/pseudo_normals.hpp"

namespace musclebench {

/// Makes contacts of nodes out of intersecting triangles, with what these alone can tell: a node of a muscle triangle
/// that intersects bone triangles is measured against the closest of the bone triangles met by its muscle triangles,
/// and is in contact where it lies behind that one. A node of no such triangle is not looked at, however deep in the
/// bone it is.
class NodeContacts {
 public:
  /// `muscle_triangles` are those that `TrianglePair` counts. Keeps references to the bones' meshes.
  NodeContacts(std::vector<const Bone*> bones, std::vector<Triangle> muscle_triangles, std::size_t nodes);

  /// Appends the contacts of `wanted` nodes (ascending) with bone `bone`, ordered by node. `positions` are in the world
  /// frame, in metres. The result does not depend on the order of `pairs`.
  void append(int bone, const RigidMotion& pose, std::span<const TrianglePair> pairs, std::span<const Vec3> positions,
              std::span<const int> wanted, std::vector<Contact>& contacts);

  [[nodiscard]] std::size_t bytes() const;

 private:
  void measure_pairs(const TriangleMesh& bone, const RigidMotion& pose, std::span<const TrianglePair> pairs,
                     std::span<const Vec3> positions);

  std::vector<const Bone*> m_bones;
  std::vector<Triangle> m_triangles;
  std::vector<PseudoNormals> m_normals;  ///< one a bone
  MetTriangles m_met;
};

}  // namespace musclebench

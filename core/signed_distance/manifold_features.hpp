#pragma once

#include <cstdint>
#include <vector>

#include "core/distance/triangle_distance.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

class MeshEdges;
class TriangleBvh;

/// Which faces, edges and vertices of a mesh are manifold in the sense that the sign of the angle-weighted
/// pseudo-normal is proven (Baerentzen and Aanaes 2005), even if the mesh elsewhere has fins, non-manifold edges or
/// overlaps. The triangles about such a feature have an area, form one closed, consistently wound fan, touch no other
/// triangle, not even to rounding, and belong to a patch that has the inside (winding number > 0.5) on its inner side
/// only. The segment from a point to its closest point crosses no surface, so that the side at its end is the side of
/// the point.
class ManifoldFeatures {
 public:
  /// `tree` and `edges` are those of the mesh. The mesh has to be closed (`is_closed`): else the inside ends in empty
  /// space somewhere.
  ManifoldFeatures(const TriangleMesh& mesh, const TriangleBvh& tree, const MeshEdges& edges);
  ManifoldFeatures(const TriangleMesh& mesh, const TriangleBvh& tree);

  [[nodiscard]] bool holds(int triangle, Feature feature) const {
    return ((m_bits[static_cast<std::size_t>(triangle)] >> static_cast<unsigned>(feature)) & 1U) != 0;
  }

  /// Prefetches what `holds` reads.
  void prefetch(int triangle) const { __builtin_prefetch(m_bits.data() + triangle); }

  [[nodiscard]] std::size_t bytes() const { return m_bits.capacity(); }

 private:
  std::vector<std::uint8_t> m_bits;  ///< by triangle, one bit a feature
};

}  // namespace musclebench

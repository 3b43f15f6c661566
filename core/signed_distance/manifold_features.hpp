#pragma once

#include <cstdint>
#include <vector>

#include "core/distance/triangle_distance.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

class MeshEdges;
class TriangleBvh;

/// Marks the faces, edges and vertices whose pseudo-normals certainly give the right side of a point. Elsewhere the
/// mesh may have fins, non-manifold edges or overlaps. Source: Baerentzen and Aanaes 2005.
///
/// The triangles around a marked feature have an area and form one closed, consistently wound fan. They touch no other
/// triangle, with a margin for rounding. The inside (winding number > 0.5) is only on the inner side of their patch.
/// The segment from a point to its closest point crosses no surface, so both ends have the same side. Queries are safe
/// from several threads.
class ManifoldFeatures {
 public:
  /// `tree` and `edges` must be built from `mesh`. The mesh must be closed (`is_closed`).
  ManifoldFeatures(const TriangleMesh& mesh, const TriangleBvh& tree, const MeshEdges& edges);
  ManifoldFeatures(const TriangleMesh& mesh, const TriangleBvh& tree);

  /// Whether `feature` of `triangle` is marked.
  [[nodiscard]] bool holds(int triangle, Feature feature) const {
    return ((m_bits[static_cast<std::size_t>(triangle)] >> static_cast<unsigned>(feature)) & 1U) != 0;
  }

  /// Prefetches the memory that `holds` reads.
  void prefetch(int triangle) const { __builtin_prefetch(m_bits.data() + triangle); }

  [[nodiscard]] std::size_t bytes() const { return m_bits.capacity(); }

 private:
  std::vector<std::uint8_t> m_bits;  ///< by triangle, one bit a feature
};

}  // namespace musclebench

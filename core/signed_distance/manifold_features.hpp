#pragma once

#include <cstdint>
#include <vector>

#include "core/bvh/triangle_bvh.hpp"
#include "core/distance/triangle_distance.hpp"
#include "core/mesh/mesh_edges.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The features of a mesh next to which the angle-weighted pseudo-normal gives the sign for certain (Baerentzen and
/// Aanaes 2005), though the mesh as a whole may have fins, edges of many faces, overlaps and other things that it can't
/// deal with. Such a feature's triangles have an area, form one closed fan that is consistently wound, touch no other
/// triangle, not even to rounding, and belong to a patch with the inside (winding number > 0.5) on its inner side only.
/// The way from a point to its closest point crosses no surface, so that the sign there is the sign here.
class ManifoldFeatures {
 public:
  /// `tree` and `edges` are those of the mesh, whose directed edges cancel (`SignedSurface::closed`): otherwise the
  /// inside ends somewhere without a surface.
  ManifoldFeatures(const TriangleMesh& mesh, const TriangleBvh& tree, const MeshEdges& edges);

  [[nodiscard]] bool holds(int triangle, Feature feature) const {
    return ((m_bits[static_cast<std::size_t>(triangle)] >> static_cast<unsigned>(feature)) & 1U) != 0;
  }

  /// What `holds` will need begins to come from memory.
  void fetch(int triangle) const { __builtin_prefetch(m_bits.data() + triangle); }

  [[nodiscard]] std::size_t bytes() const { return m_bits.capacity(); }

 private:
  std::vector<std::uint8_t> m_bits;  ///< of each triangle, one a feature
};

}  // namespace musclebench

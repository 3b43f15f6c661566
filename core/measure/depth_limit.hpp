#pragma once

#include <string>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// What lengths of a muscle are compared with; 0: unknown.
struct MuscleSize {
  std::string name = {};
  double mean_edge_length_m = 0;  ///< at rest
  double diagonal_m = 0;          ///< of its box at rest
  int triangles = 0;
};

/// The same of a bone.
struct BoneSize {
  std::string name = {};
  double thickness_m = 0;  ///< see thickness_m; 0: it encloses no volume
};

/// Twice the volume over the area: of a plate its thickness, of a rod half of its diameter, of a ball a third. It is no
/// smaller for a finer mesh or another orientation. 0 for a
/// sheet, which encloses nothing.
double thickness_m(const TriangleMesh& mesh);

MuscleSize size_of(const std::string& name, const TriangleMesh& muscle);

/// How deep a muscle may be in a bone, or in another muscle, in a run that is ok.
struct DepthLimit {
  double depth_m = 0;
  std::string because;  ///< of which length it is which share, in words
};

/// The smallest of the shares of its lengths that outcome_limits names (depth_edges, depth_share, thickness_share), so
/// that neither a coarse mesh nor a large muscle beside a thin bone makes it large. Infinite where no length is known.
DepthLimit depth_limit(const MuscleSize& muscle, const BoneSize& bone);
DepthLimit depth_limit(const MuscleSize& muscle, const MuscleSize& other);

}  // namespace musclebench

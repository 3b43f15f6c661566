#pragma once

#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// How a scene reads the coordinates of a mesh: it divides them by `units_per_metre`, scales them along the mesh's
/// axes, turns them about the scene's x axis, then y, then z (right-handed), and moves them. Points of landmark files
/// follow the mesh that they describe, but are in metres whatever its unit.
struct MeshPlacement {
  double units_per_metre = 1;
  Vec3 scale = Vec3::Ones();  ///< above zero: a mirrored surface would be inside out
  Vec3 rotate_deg = Vec3::Zero();
  Vec3 translate_m = Vec3::Zero();

  /// Steps that change nothing leave the bits of the vertices alone.
  void apply_to(std::vector<Vec3>& vertices) const;
  /// `points`: in metres, in the mesh's own frame.
  void apply_to_metres(std::vector<Vec3>& points) const;
  [[nodiscard]] bool changes_metres() const;
};

}  // namespace musclebench

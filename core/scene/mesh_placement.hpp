#pragma once

#include <string>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"
#include "core/scene/toml_table.hpp"

namespace musclebench {

/// How a scene reads the coordinates of a mesh: it divides them by `units_per_metre`, scales them along the mesh's
/// axes, turns them about the scene's x axis, then y, then z (right-handed), and moves them.
struct MeshPlacement {
  double units_per_metre = 1;
  Vec3 scale = Vec3::Ones();  ///< above zero: a mirrored surface would be inside out
  Vec3 rotate_deg = Vec3::Zero();
  Vec3 translate_m = Vec3::Zero();

  /// Steps that change nothing leave the bits of the vertices alone.
  void apply_to(std::vector<Vec3>& vertices) const;
};

/// The keys of a [[bone]] or [[muscle]] that say so.
inline const std::vector<std::string> placement_keys = {"unit", "scale", "rotate_deg", "translate_m"};

/// What `table` says; the identity without these keys. Throws InputError.
MeshPlacement read_placement(const TomlTable& table);

}  // namespace musclebench

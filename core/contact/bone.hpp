#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/mesh_repair/repair_mesh.hpp"
#include "core/signed_distance/shared_surface.hpp"

namespace musclebench {

/// A rigid bone as a backend receives it: its repaired surface in rest pose, in metres. Scenes sort its vertices and
/// triangles in Morton order, so that neighbours are close in memory. Set `surface` before the first query and do not
/// change it afterwards. The first call of each query builds a structure, so it must not run in two threads at once.
struct Bone {
  std::string name;
  RepairedMesh surface;
  SharedSurface shared = {};  ///< structures over `surface`

  /// The BVH over `surface`. It is built at the first call (see SharedSurface).
  [[nodiscard]] const TriangleBvh& tree() const { return shared.tree(surface); }
  /// The exact signed distance to `surface`, built at the first call.
  [[nodiscard]] const SignedSurface& signed_distance() const { return shared.signed_distance(surface); }
  /// The same, which stays valid as long as the caller holds it.
  [[nodiscard]] std::shared_ptr<const SignedSurface> kept_signed_distance() const {
    return shared.kept_signed_distance(surface);
  }
};

/// Pointers to all bones, for functions that take a selection of bones.
inline std::vector<const Bone*> pointers_to(std::span<const Bone> bones) {
  std::vector<const Bone*> pointers;
  for (const Bone& bone : bones) pointers.push_back(&bone);
  return pointers;
}

}  // namespace musclebench

#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/mesh_repair/repair_mesh.hpp"
#include "core/signed_distance/shared_surface.hpp"

namespace musclebench {

/// A rigid bone as a backend gets it: its repaired surface in rest pose. In a scene it is in Morton order
/// (`sort_in_morton_order`): what lies close together does so in memory, too.
struct Bone {
  std::string name;
  RepairedMesh surface;
  SharedSurface shared = {};  ///< of `surface`, which stays as it is from the first use on

  /// Built once, in the rest frame (see SharedSurface).
  [[nodiscard]] const TriangleBvh& tree() const { return shared.tree(surface); }
  [[nodiscard]] const SignedSurface& signed_distance() const { return shared.signed_distance(surface); }
  [[nodiscard]] std::shared_ptr<const SignedSurface> kept_signed_distance() const {
    return shared.kept_signed_distance(surface);
  }
};

/// For what takes a choice of bones.
inline std::vector<const Bone*> pointers_to(std::span<const Bone> bones) {
  std::vector<const Bone*> pointers;
  for (const Bone& bone : bones) pointers.push_back(&bone);
  return pointers;
}

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "backends/fcl/fcl_options.hpp"
#include "backends/fcl/surfaces/muscle_surface.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// A triangle of the muscle and a triangle of a bone that intersect.
struct TrianglePair {
  int muscle_triangle = 0;  ///< of the mesh of all muscles
  int bone_triangle = 0;
};

/// FCL's part of `Query::surfaces`, without FCL's types: all pairs of intersecting triangles of muscles' surfaces
/// and rigid bones.
class SurfaceCollider {
 public:
  SurfaceCollider() = default;
  SurfaceCollider(const SurfaceCollider&) = delete;
  SurfaceCollider& operator=(const SurfaceCollider&) = delete;
  virtual ~SurfaceCollider() = default;

  /// Moves the bones and deforms the muscles; all in the world frame, in metres.
  virtual void update(std::span<const RigidMotion> bone_poses, std::span<const Vec3> positions) = 0;

  /// The pairs that FCL finds after the last `update`, one list a bone and muscle (bone after bone), overwritten. The
  /// order within a list is that of FCL's traversal, the same in every call and for any number of threads. Empty lists
  /// where the muscle's positions were not finite. All pairs that intersect, but with RSS volumes that are refitted
  /// bottom up: FCL 0.7 then misses some or all.
  virtual void collide(std::vector<std::vector<TrianglePair>>& pairs) = 0;

  /// Of the last `collide`: how long each list took.
  [[nodiscard]] virtual std::span<const Nanoseconds> times() const = 0;

  /// Bytes of the models, objects and managers, counted from their sizes.
  [[nodiscard]] virtual std::size_t bytes() const = 0;
};

/// Builds one model a bone and one a muscle, as bodies are to FCL. Different pairs of them are collided in up to
/// `threads` threads. Throws InputError for an unknown bounding volume.
std::unique_ptr<SurfaceCollider> make_surface_collider(const FclOptions& options, std::span<const Bone* const> bones,
                                                       std::vector<MuscleSurface> muscles, int threads);

}  // namespace musclebench

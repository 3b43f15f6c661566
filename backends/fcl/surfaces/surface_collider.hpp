#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "backends/fcl/fcl_options.hpp"
#include "backends/fcl/surfaces/muscle_surface.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// A triangle of a muscle and a triangle of a bone, or of another muscle, that intersect.
struct TrianglePair {
  int muscle_triangle = 0;  ///< of the mesh of all muscles
  int other_triangle = 0;   ///< of the bone's mesh, or of that of all muscles
};

/// FCL's part of `Query::surfaces`, without FCL's types: all pairs of intersecting triangles of muscles' surfaces,
/// which deform, with rigid bones or each other.
class SurfaceCollider {
 public:
  SurfaceCollider() = default;
  SurfaceCollider(const SurfaceCollider&) = delete;
  SurfaceCollider& operator=(const SurfaceCollider&) = delete;
  virtual ~SurfaceCollider() = default;

  virtual void move_bones(std::span<const RigidMotion> poses) = 0;

  /// Refits the tree of one muscle. `positions` are of all nodes, world frame, m. Different muscles may be deformed by
  /// several threads at once.
  virtual void deform(std::size_t muscle, std::span<const Vec3> positions) = 0;

  /// The pairs that FCL finds between bones and muscles, one list a bone and muscle (bone after bone), overwritten. The
  /// order within a list is that of FCL's traversal, the same in every call and for any number of threads. Empty lists
  /// where the muscle's positions were not finite. All pairs that intersect, but with RSS volumes that are refitted
  /// bottom up: FCL 0.7 then misses some or all.
  virtual void collide_bones(std::vector<std::vector<TrianglePair>>& pairs) = 0;

  /// Of the last `collide_bones`: how long each list took.
  [[nodiscard]] virtual std::span<const Nanoseconds> times() const = 0;

  /// The same of two muscles, none where their boxes do not overlap. Different pairs may be collided by several threads
  /// at once.
  virtual void collide_muscles(std::size_t first, std::size_t second, std::vector<TrianglePair>& pairs) = 0;

  /// Bytes of the models, objects and managers, counted from their sizes.
  [[nodiscard]] virtual std::size_t bytes() const = 0;
};

/// Builds one model a bone and one a muscle, as bodies are to FCL. Different bones and muscles are collided in
/// up to `threads` threads. Throws InputError for an unknown bounding volume.
std::unique_ptr<SurfaceCollider> make_surface_collider(const FclOptions& options, std::span<const Bone* const> bones,
                                                       std::vector<MuscleSurface> muscles, int threads);

}  // namespace musclebench

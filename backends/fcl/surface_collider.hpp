#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// How the muscle's tree follows its vertices: new volumes from the leaves up or from the root down in the tree as
/// built at rest, or a new tree.
enum class TreeUpdate { refit, refit_top_down, rebuild };

/// Which of FCL's two ways gives the model its new vertices: `replace` forgets the old ones, `update` keeps them and
/// makes each volume enclose old and new (meant for continuous collision; slower, and the answers are the same).
enum class VertexUpdate { replace, update };

enum class BroadPhase { dynamic_aabb_tree, sweep_and_prune };

struct ColliderOptions {
  std::string bounding_volume = "OBBRSS";  ///< one of `bounding_volumes()`
  BroadPhase broad_phase = BroadPhase::dynamic_aabb_tree;
  TreeUpdate tree_update = TreeUpdate::refit;
  VertexUpdate vertex_update = VertexUpdate::replace;
};

/// A triangle of the muscle and a triangle of a bone that intersect.
struct TrianglePair {
  int muscle_triangle = 0;
  int bone_triangle = 0;
};

/// FCL's part of the backend, without FCL's types: all pairs of intersecting triangles of a muscle surface and rigid
/// bones.
class SurfaceCollider {
 public:
  SurfaceCollider() = default;
  SurfaceCollider(const SurfaceCollider&) = delete;
  SurfaceCollider& operator=(const SurfaceCollider&) = delete;
  virtual ~SurfaceCollider() = default;

  /// Moves the bones and deforms the muscle; all in the world frame, in metres.
  virtual void update(std::span<const RigidMotion> bone_poses, std::span<const Vec3> positions) = 0;

  /// The intersecting pairs of the last `update`, one list a bone, overwritten. The order within a list is that of
  /// FCL's traversal, the same in every call. Empty lists where the positions were not finite.
  virtual void collide(std::vector<std::vector<TrianglePair>>& pairs_by_bone) = 0;

  /// Bytes of the models, objects and managers, counted from their sizes.
  [[nodiscard]] virtual std::size_t bytes() const = 0;
};

/// The names that `ColliderOptions::bounding_volume` may have.
const std::vector<std::string>& bounding_volumes();

/// Builds one model a bone and one of the muscle (`rest_positions`, `muscle_triangles`: at least one, none without
/// area). Throws InputError for options that FCL answers wrongly.
std::unique_ptr<SurfaceCollider> make_surface_collider(const ColliderOptions& options, std::span<const Bone> bones,
                                                       std::span<const Vec3> rest_positions,
                                                       std::span<const Triangle> muscle_triangles);

/// Throws InputError (place: fcl) where FCL 0.7 is known to answer wrongly with these options.
void check_collider_options(const ColliderOptions& options);

}  // namespace musclebench

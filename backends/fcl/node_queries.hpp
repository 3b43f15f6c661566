#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "backends/fcl/fcl_options.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// FCL's part of the queries of single nodes, without FCL's types. FCL takes a bone's surface for hollow: it tells how
/// far a triangle is, never on which side. The side comes from the pseudo-normal of the triangle that FCL names, so it
/// may be wrong where the surface is not clean.
///
/// - `Query::node_distance` asks for the distance of a point (a sphere of radius 0: where a larger one overlaps a
///   triangle, FCL 0.7 leaves the distance unset).
/// - `Query::node_collide` asks which triangles a sphere of `node_radius_m` meets and takes the closest of them. A node
///   farther from the surface than that, on either side, meets none.
///
/// Nodes are asked in the bone's rest frame: moved models without orientation would be rebuilt in every query. What FCL
/// finds is measured again here (see NodeSurface).
class NodeQueries {
 public:
  /// Builds one model a bone; keeps references to the bones and their meshes. Throws InputError for an unknown bounding
  /// volume.
  NodeQueries(const FclOptions& options, std::span<const Bone> bones, int threads);
  NodeQueries(const NodeQueries&) = delete;
  NodeQueries& operator=(const NodeQueries&) = delete;
  ~NodeQueries();

  void move_bones(std::span<const RigidMotion> poses);

  /// Appends the contacts of `nodes` (ascending), ordered by bone, then node; `positions` in the world frame, in
  /// metres. A position that is not finite has no contact. The same bits for any number of threads.
  void append(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts);

  /// A node closer to the surface of `bone` than this, in metres, has no contact: which side it is on is rounding.
  [[nodiscard]] double touching_m(int bone) const;

  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> m_implementation;
};

}  // namespace musclebench

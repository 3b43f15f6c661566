#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/contact/bone.hpp"
#include "core/effects/no_passage/joined_sets.hpp"
#include "core/effects/no_passage/passage_paths.hpp"
#include "core/mesh/body.hpp"

namespace musclebench {

/// What goes through a collider as the run begins, and has since: nodes of triangles that intersect it, and such as
/// these separate from the outside, inside of it. They can't be held apart from it, and have to get out. Colliders are
/// the bones, then the muscles.
class LeftOut {
 public:
  /// All are kept by reference. What reaches through by less than `touching_m` only touches.
  LeftOut(PassagePaths& paths, std::span<const Bone> bones, std::span<const Body> bodies, double touching_m);

  /// The first time takes all that is so with nodes at `at`, world frame, m; later leaves what no longer is. Sets the
  /// paths to stay there.
  void update(std::span<const Vec3> at, std::span<const RigidMotion> poses);
  [[nodiscard]] bool is_any() const { return m_is_any; }
  /// Whether a stencil is of a node that is left out with the collider on the other side.
  [[nodiscard]] bool has(const PassageStencil& stencil) const;
  /// Whether one of two triangles has a node that is left out with the other's surface; see PassageOverlap.
  [[nodiscard]] bool concerns(int bone, std::size_t triangle, std::size_t other) const;

 private:
  [[nodiscard]] std::size_t nodes() const { return m_paths.mesh().vertices.size(); }
  [[nodiscard]] std::size_t slot(std::size_t collider, int node) const {
    return collider * nodes() + static_cast<std::size_t>(node);
  }
  [[nodiscard]] std::size_t muscle_of(std::size_t triangle) const {
    return m_bones.size() + m_paths.body_of_node(m_paths.mesh().triangles[triangle][0]);
  }
  [[nodiscard]] bool has_any(std::size_t collider, std::size_t triangle) const;
  [[nodiscard]] std::vector<char> intersecting(bool is_first);
  void add_enclosed(std::size_t collider, std::span<const char> intersects, bool is_first, std::span<const Vec3> at,
                    std::span<const RigidMotion> poses);
  [[nodiscard]] bool is_inside(std::size_t collider, std::span<const int> nodes, std::span<const Vec3> at,
                               std::span<const RigidMotion> poses) const;

  PassagePaths& m_paths;
  std::span<const Bone> m_bones;
  std::span<const Body> m_bodies;
  double m_touching_m;
  std::vector<char> m_is_out;  ///< [collider * nodes + node]
  std::vector<char> m_is_still_out;
  JoinedSets m_parts;
  bool m_is_any = false;
  bool m_is_first = true;
};

}  // namespace musclebench

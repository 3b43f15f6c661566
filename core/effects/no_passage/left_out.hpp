#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/contact/bone.hpp"
#include "core/effects/no_passage/passage_overlaps.hpp"
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

  /// Takes all that is so with nodes at `at`, world frame, m. Sets the paths to stay there.
  void begin(std::span<const Vec3> at, std::span<const RigidMotion> poses);
  /// Drops what no longer is. `through`: all pairs that `concerns` of triangles that go through each other there.
  void update(std::span<const TrianglePair> through, std::span<const Vec3> at, std::span<const RigidMotion> poses);
  [[nodiscard]] bool is_any() const { return m_left > 0; }
  /// Whether a stencil is of a node that is left out with the collider on the other side.
  [[nodiscard]] bool has(const PassageStencil& stencil) const;
  /// Whether one of two triangles has a node that is left out with the other's surface.
  [[nodiscard]] bool concerns(const TrianglePair& pair) const;

 private:
  /// Nodes that are left out with a collider, and hang together. They get free of it together.
  struct Part {
    std::size_t collider;
    std::vector<int> nodes;
  };

  [[nodiscard]] std::size_t nodes() const { return m_paths.mesh().vertices.size(); }
  [[nodiscard]] std::size_t slot(std::size_t collider, int node) const {
    return collider * nodes() + static_cast<std::size_t>(node);
  }
  [[nodiscard]] std::size_t muscle_of(std::size_t triangle) const {
    return m_bones.size() + m_paths.body_of_node(m_paths.mesh().triangles[triangle][0]);
  }
  [[nodiscard]] bool is_of(std::size_t collider, int node) const {
    return collider >= m_bones.size() && m_bodies[collider - m_bones.size()].has_node(node);
  }
  [[nodiscard]] bool has_any(std::size_t collider, std::size_t triangle) const;
  /// Calls `mark(collider, node)` for the nodes of both triangles.
  template <typename Mark>
  void for_each_node(const TrianglePair& pair, const Mark& mark) const;
  /// The nodes that `is_wanted` is true of, by what hangs together along edges.
  template <typename IsWanted>
  [[nodiscard]] std::vector<std::vector<int>> joined(const IsWanted& is_wanted) const;
  [[nodiscard]] bool is_inside(std::size_t collider, std::span<const int> nodes, std::span<const Vec3> at,
                               std::span<const RigidMotion> poses) const;

  PassagePaths& m_paths;
  std::span<const Bone> m_bones;
  std::span<const Body> m_bodies;
  double m_touching_m;
  std::vector<Part> m_parts;
  std::vector<int> m_part_of;  ///< [collider * nodes + node]: the number of a part, or -1
  std::size_t m_left = 0;      ///< of the parts, those that are not free yet
};

}  // namespace musclebench

#pragma once

#include <array>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A closed manifold triangle surface that can be edited. Half-edge h = 3 t + i runs from corner i of triangle t to its
/// next corner. Every edit keeps the surface closed and manifold, or refuses and says so.
class EditableSurface {
 public:
  /// `mesh` must be closed, manifold and consistently wound.
  explicit EditableSurface(const TriangleMesh& mesh);

  /// What is left, without the removed parts; the order of the remaining vertices is kept.
  [[nodiscard]] TriangleMesh mesh() const;

  [[nodiscard]] int half_edges() const { return static_cast<int>(m_opposite.size()); }
  [[nodiscard]] int vertex_slots() const { return static_cast<int>(m_position.size()); }
  [[nodiscard]] int vertex_count() const { return m_vertex_count; }
  [[nodiscard]] bool alive(int h) const { return m_opposite[at(h)] >= 0; }
  [[nodiscard]] bool vertex_alive(int v) const { return m_first[at(v)] >= 0; }

  [[nodiscard]] static int next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
  [[nodiscard]] static int previous(int h) { return h % 3 == 0 ? h + 2 : h - 1; }
  [[nodiscard]] int opposite(int h) const { return m_opposite[at(h)]; }
  [[nodiscard]] int origin(int h) const { return m_corner[at(h)]; }
  [[nodiscard]] int target(int h) const { return origin(next(h)); }
  [[nodiscard]] int tip(int h) const { return origin(previous(h)); }

  /// One half-edge that starts at v, and the next one around its origin.
  [[nodiscard]] int first_from(int v) const { return m_first[at(v)]; }
  [[nodiscard]] int next_from(int h) const { return opposite(previous(h)); }
  [[nodiscard]] int valence(int v) const;

  [[nodiscard]] const Vec3& position(int v) const { return m_position[at(v)]; }
  void move(int v, const Vec3& to) { m_position[at(v)] = to; }
  [[nodiscard]] double length(int h) const { return (position(target(h)) - position(origin(h))).norm(); }
  /// Twice the area times the unit normal of the triangle of h.
  [[nodiscard]] Vec3 normal(int h) const;

  /// Splits the edge by a new vertex at `to`, which it returns.
  int split(int h, const Vec3& to);
  /// Flips the edge: replaces it by the other diagonal of its two triangles. Refuses where that exists already or a
  /// valence would fall below 3.
  bool flip(int h);
  /// Collapses the edge into its target, moved to `to`; the origin is removed. Refuses where the surface would be
  /// pinched.
  bool collapse(int h, const Vec3& to);

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] bool connected(int v, int w) const;
  void set_triangle(int t, int a, int b, int c);
  void link(int h, int o);

  std::vector<Vec3> m_position;
  std::vector<int> m_first;     ///< of a vertex; -1: removed
  std::vector<int> m_corner;    ///< of a half-edge: its origin
  std::vector<int> m_opposite;  ///< of a half-edge; -1: removed
  int m_vertex_count = 0;
};

}  // namespace musclebench

#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <mutex>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/effects/no_passage/sphere_lanes.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The triangles of a surface by eights: those of one leaf are close together, as are the leaves of one node above.
/// Level 0 are the triangles, level 1 leaves of eight, and so on up to one root, which the tree may have more than once
/// above each other. Nodes of a level are numbered by place; the children of node n are 8 n to 8 n + 7.
class TriangleTree {
 public:
  /// Over the triangles from `first` to before `last`; `at`: positions of all vertices. `levels`: at least so many
  /// above the triangles; 2 or more.
  TriangleTree(std::span<const Triangle> triangles, std::span<const Vec3> at, std::size_t first, std::size_t last,
               int levels = 2);

  /// The level of the root.
  [[nodiscard]] int top() const { return static_cast<int>(m_sizes.size()) - 1; }
  [[nodiscard]] std::size_t size(int level) const { return m_sizes[static_cast<std::size_t>(level)]; }
  [[nodiscard]] std::size_t triangle(std::size_t place) const { return static_cast<std::size_t>(m_triangles[place]); }
  /// The vertices of all triangles below a node of level 1 or 2, each once and the last as often as fills up fours.
  [[nodiscard]] std::span<const int> vertices(int level, std::size_t node) const {
    const Lists& of = m_vertices[static_cast<std::size_t>(level) - 1];
    return std::span(of.numbers).subspan(of.first[node], of.first[node + 1] - of.first[node]);
  }
  /// The nodes of level 1 with a triangle at a vertex.
  [[nodiscard]] std::span<const int> leaves(int vertex) const {
    const std::size_t v = static_cast<std::size_t>(vertex) - m_first_vertex;
    return std::span(m_leaves.numbers).subspan(m_leaves.first[v], m_leaves.first[v + 1] - m_leaves.first[v]);
  }

 private:
  struct Lists {
    std::vector<std::size_t> first;  ///< of each list, and one past the last
    std::vector<int> numbers;
  };
  std::vector<int> m_triangles;
  std::vector<std::size_t> m_sizes;  ///< by level
  std::array<Lists, 2> m_vertices;   ///< by level from 1 on and node
  std::size_t m_first_vertex = 0;
  Lists m_leaves;  ///< by vertex from there
};

/// Four single-precision numbers, which most processors take at once.
using Four = Eigen::Array4f;

/// How a vertex moves, in single precision: relative to the origin of its PathSpheres, m; the last numbers are 0.
struct VertexPath {
  Four from = Four::Zero();
  Four move = Four::Zero();

  VertexPath() = default;
  VertexPath(const Vec3& start, const Vec3& end, const Vec3& origin);
};

/// A triangle's corners.
using TrianglePath = std::array<const VertexPath*, 3>;

/// A sphere around vertices that move along straight paths: its centre moves straight, too.
struct PathSphere {
  Vec3 from = Vec3::Zero();  ///< the centre, m
  Vec3 to = Vec3::Zero();
  double radius_m = 0;  ///< where the paths start
  double spread_m = 0;  ///< no vertex moves otherwise than the centre by more

  static PathSphere around(std::span<const int> vertices, std::span<const VertexPath> paths, const Vec3& origin);
  static PathSphere around(std::span<const PathSphere> parts);
};

/// The spheres of a surface's tree in one frame, made as they are asked for. Several threads may ask for them at once.
/// Paths are set and changed only while none does, and what was asked for holds until then.
class PathSpheres {
 public:
  /// The tree is kept by reference. `origin`: see SphereLanes.
  PathSpheres(const TriangleTree& tree, const Vec3& origin);
  virtual ~PathSpheres() = default;
  PathSpheres(const PathSpheres&) = delete;
  PathSpheres& operator=(const PathSpheres&) = delete;

  [[nodiscard]] const TriangleTree& tree() const { return m_tree; }
  /// The paths of these vertices have changed since they were set, those of all others have not.
  void change(std::span<const int> vertices);
  [[nodiscard]] bool is_all_changed() const { return m_is_all_changed; }
  /// Of the nodes of a level, by number: whether one has such a vertex. Says nothing while all are changed.
  struct Changed {
    const unsigned* changed_in;
    unsigned change;

    bool operator[](int node) const { return changed_in[node] == change; }
  };
  [[nodiscard]] Changed changed(int level) const {
    return {m_levels[static_cast<std::size_t>(level) - 1].changed.data(), m_changes};
  }
  /// Of the children of a node of level 1 or more.
  [[nodiscard]] const SphereLanes& below(int level, std::size_t node) {
    Level& of = m_levels[static_cast<std::size_t>(level) - 1];
    if (of.made[node].load(std::memory_order_acquire) != m_paths) make(level, node);
    return of.below[node];
  }
  /// Of the nodes of a level below the root, by number: how the centre moves, m, and its spread.
  struct Motions {
    PathSpheres& of;
    const Four* all;
    const std::atomic<unsigned>* made;
    unsigned paths;
    int level_above;

    const Four& operator[](int node) const {
      const std::size_t above = static_cast<std::size_t>(node) / bvh_width;
      if (made[above].load(std::memory_order_acquire) != paths) [[unlikely]]
        of.make(level_above, above);
      return all[node];
    }
  };
  [[nodiscard]] Motions motions(int level) {
    const Level& above = m_levels[static_cast<std::size_t>(level)];
    return {*this, above.motions.data(), above.made.data(), m_paths, level + 1};
  }

 protected:
  /// What was made is of other paths.
  void forget() {
    ++m_paths;
    m_is_all_changed = true;
  }
  virtual void forget_vertex(int /*vertex*/) {}
  virtual void forget_sphere(int /*level*/, std::size_t /*node*/) {}
  virtual void fill(int level, std::size_t node, SphereLanes& lanes) = 0;
  /// Held while something is made.
  std::mutex& making() { return m_making; }
  void set(SphereLanes& lanes, std::size_t lane, const PathSphere& sphere) const;
  /// So that it is far from everything.
  static void clear(SphereLanes& lanes, std::size_t lane);
  /// Of up to eight triangles.
  static void set_triangles(SphereLanes& lanes, std::size_t count, const std::array<TrianglePath, bvh_width>& paths);

  const TriangleTree& m_tree;
  Vec3 m_origin;         ///< of `from` in the lanes
  unsigned m_paths = 1;  ///< counts them

 private:
  struct Level {
    explicit Level(std::size_t nodes) : below(nodes), made(nodes), changed(nodes), motions(nodes * bvh_width) {}

    std::vector<SphereLanes> below;           ///< by node
    std::vector<std::atomic<unsigned>> made;  ///< by node: from what paths
    std::vector<unsigned> changed;            ///< by node: in what change
    std::vector<Four> motions;                ///< by child
  };
  void make(int level, std::size_t node);

  std::vector<Level> m_levels;  ///< from 1 on
  std::mutex m_making;
  unsigned m_changes = 1;  ///< counts them from 1 on: nodes that never changed have 0
  bool m_is_all_changed = true;
};

/// Where the paths are given.
class GivenPaths final : public PathSpheres {
 public:
  GivenPaths(const TriangleTree& tree, std::span<const Triangle> triangles);

  /// By vertex, relative to `origin`; kept by reference.
  void set(std::span<const VertexPath> paths, const Vec3& origin);
  /// Of a node of level 1 or more. Paths in a bone ask for it while they make theirs: of the two locks theirs is first.
  [[nodiscard]] PathSphere sphere(int level, std::size_t node);
  [[nodiscard]] TrianglePath triangle(std::size_t triangle) const;

 private:
  const PathSphere& make_sphere(int level, std::size_t node);
  void fill(int level, std::size_t node, SphereLanes& lanes) override;
  void forget_sphere(int level, std::size_t node) override {
    m_spheres[static_cast<std::size_t>(level) - 1][node].paths = 0;
  }

  struct Made {
    PathSphere sphere;
    unsigned paths = 0;
  };
  std::span<const Triangle> m_triangles;
  std::span<const VertexPath> m_vertices;
  std::vector<std::vector<Made>> m_spheres;  ///< by level from 1 on and node
};

/// The same in the rest frame of a bone that moves. What the bone carries itself is nowhere.
class PathsInBone final : public PathSpheres {
 public:
  /// `is_carried`: by vertex. `first_vertex`, `last_vertex`: range of those of `given`, the last one past.
  PathsInBone(GivenPaths& given, std::span<const Triangle> triangles, std::span<const char> is_carried,
              std::size_t first_vertex, std::size_t last_vertex, const Vec3& origin);

  /// What `given` was set to, world frame, kept by reference, and the bone's poses at both ends.
  void set(std::span<const Vec3> start, std::span<const Vec3> end, const RigidMotion& from, const RigidMotion& to);
  [[nodiscard]] Vec3 start(int vertex) const {
    return m_from.apply_inverse(m_world_start[static_cast<std::size_t>(vertex)]);
  }
  [[nodiscard]] Vec3 end(int vertex) const { return m_to.apply_inverse(m_world_end[static_cast<std::size_t>(vertex)]); }
  /// One whose sphere was asked for.
  [[nodiscard]] TrianglePath triangle(std::size_t triangle) const;
  [[nodiscard]] const Mat3& from_world() const { return m_from_world; }  ///< directions where the paths start

 private:
  void fill(int level, std::size_t node, SphereLanes& lanes) override;
  void forget_vertex(int vertex) override { m_placed[static_cast<std::size_t>(vertex) - m_first_vertex].paths = 0; }

  struct Placed {
    VertexPath path;
    unsigned paths = 0;
  };
  GivenPaths& m_given;
  std::span<const Triangle> m_triangles;
  std::vector<std::vector<char>> m_is_out;  ///< by level and node: carried whole
  std::span<const Vec3> m_world_start;
  std::span<const Vec3> m_world_end;
  RigidMotion m_from;
  RigidMotion m_to;
  Mat3 m_from_world = Mat3::Identity();
  double m_turn = 0;  ///< no unit vector is changed by more
  std::size_t m_first_vertex;
  std::vector<Placed> m_placed;  ///< by vertex from there
};

}  // namespace musclebench

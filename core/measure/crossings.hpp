#pragma once

#include <compare>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/contact/bone.hpp"
#include "core/mesh/body.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/referee/referee.hpp"

namespace musclebench {

/// What a muscle's triangles are tested against.
enum class CrossedSurface { bone, muscle, itself };

/// A muscle and a surface that it may pass through.
struct CrossingPair {
  int muscle = 0;  ///< index of the body whose triangles are counted
  CrossedSurface kind = CrossedSurface::itself;
  int other = 0;     ///< index of the bone, or of the body
  int left_out = 0;  ///< triangles of the muscle that do not count, as they are attached to that bone
};

/// A triangle that is, at least in part, in another muscle.
struct TriangleInMuscle {
  int triangle = 0;
  int other = 0;  ///< the muscle

  friend auto operator<=>(const TriangleInMuscle&, const TriangleInMuscle&) = default;
};

/// Over all muscles.
struct CrossingSums {
  int in_bones = 0;
  std::optional<int> in_muscles;  ///< nothing where there is one muscle
  int in_itself = 0;
};
CrossingSums sums_of(std::span<const CrossingPair> pairs, std::span<const int> counts);

/// Counts the triangles of muscles that pass through bones, other muscles or the muscle itself.
///
/// A triangle passes through a surface where it passes through one of its triangles (pass_through_each_other): decided
/// without rounding errors for the points as given; what only touches does not count. Within one muscle two triangles
/// that share an edge never count, and two that share a vertex only where they pass through each other elsewhere.
///
/// Muscles are compared in the world frame, with no point rounded. Against a bone each node is brought into the bone's
/// rest frame, rounded once for all triangles around it, so that the bone's vertices stay what they are: the surface
/// that is tested is closed, and off by rounding of the pose at most. In a bone that stands where it rests nothing is
/// rounded.
///
/// Against a bone a triangle is left out where that bone carries one of its nodes, or where all of its nodes are
/// carried by bones: what is attached lies in the bone by intention.
class CrossingMeter {
 public:
  /// `muscles`: the mesh of all bodies. `carriers`: for every node the bone that carries it, -1 for a free node.
  CrossingMeter(std::span<const Bone> bones, const TriangleMesh& muscles, std::span<const Body> bodies,
                std::span<const int> carriers);

  /// Muscle after muscle: with each bone, with each later muscle, with itself.
  [[nodiscard]] std::span<const CrossingPair> pairs() const { return m_pairs; }

  /// Triangles that pass through, of each of `pairs()`; of two muscles those of the first. `referee` has the trees of
  /// the bones, `tree` is that of the muscles, refitted to `positions` (finite; world frame).
  std::vector<int> count(const Referee& referee, const RefereeTree& tree, std::span<const RigidMotion> poses,
                         std::span<const Vec3> positions);

  /// What the last call found counts as at rest from now on.
  void take_as_rest();

  /// Of the last call, of each of `pairs()`: triangles beyond those at rest. What overlaps at rest is no excuse for
  /// passing elsewhere: the number at rest is taken off those alone that passed at rest or share a node with one.
  /// All of them before `take_as_rest`.
  [[nodiscard]] std::vector<int> beyond_rest() const;

  /// Of the last call: triangles that pass through other muscles, of both; ascending, each once a muscle.
  [[nodiscard]] std::span<const TriangleInMuscle> in_muscles() const { return m_in_muscles; }

  /// Of the last call, in the unit of RefereeTree.
  [[nodiscard]] long last_work() const { return m_work; }

 private:
  /// A triangle that counts in a pair.
  struct Passing {
    std::size_t pair = 0;
    int triangle = 0;
  };

  [[nodiscard]] bool is_left_out(const Triangle& triangle, int bone) const;
  void find_in_bone(std::size_t pair, const RefereeTree& tree);
  [[nodiscard]] bool passes_through_bone(const Triangle& triangle, int bone, const RefereeTree& tree);
  void find_in_muscles(const RefereeTree& tree, std::span<const Vec3> positions);
  [[nodiscard]] std::vector<int> counts_of_last() const;
  [[nodiscard]] std::size_t pair_of(std::size_t muscle, std::size_t other) const;

  std::vector<TriangleMesh> m_bones;
  std::vector<Eigen::AlignedBox3d> m_bone_boxes;
  std::vector<Triangle> m_triangles;
  std::vector<Body> m_bodies;
  std::vector<int> m_carriers;
  std::vector<CrossingPair> m_pairs;
  std::vector<int> m_at_rest;                     // by pair; empty: nothing is known of it
  std::vector<std::vector<char>> m_near_at_rest;  // by pair and triangle: is one at rest or beside one; empty: none is
  std::vector<Passing> m_passing;                 // of the last call
  long m_work = 0;
  // Scratch memory.
  std::vector<Vec3> m_rest;  // nodes in the bone's frame
  std::vector<int> m_near;
  std::vector<char> m_crosses_itself;
  std::vector<TriangleInMuscle> m_in_muscles;
};

/// Triangles of a muscle that are those of another, corner by corner.
struct SharedFaces {
  int muscle = 0, other = 0;
  int triangles = 0;
};

/// Of each two muscles that have some. Such triangles touch and do not pass through each other, although one muscle
/// lies in the other.
std::vector<SharedFaces> shared_faces(const TriangleMesh& muscles, std::span<const Body> bodies);

/// Triangles of the surface that pass through others of it. Positions must be finite.
int count_self_crossings(const TriangleMesh& mesh);

}  // namespace musclebench

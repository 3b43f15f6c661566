#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/referee/referee.hpp"

namespace musclebench {

/// The deepest point of the muscle's surface inside a bone.
struct DeepestSurfacePoint {
  double depth_m = 0;  ///< 0: the surface is outside all bones
  int bone = -1;
  int triangle = -1;            ///< of the muscle; -1 where the point is a node
  Vec3 point_m = Vec3::Zero();  ///< world
};

/// Finds how deep the muscle's surface, not only its nodes, is inside the bones: all nodes can be outside while a
/// bone's ridge cuts through a face.
///
/// Branch and bound over the triangles: the signed distance of a point p changes by at most the way that p moves, so no
/// point of a triangle is deeper than the depth of its centroid plus the radius about it. Nor is it deeper than b when
/// the triangle, moved aside by b, lies outside the bone: that leaves out what lies along a bone. What is not left out
/// is split. The answer is the depth of a point of the surface, so never too large, and at most
/// `relative_tolerance * depth + absolute_tolerance * (the bone's diagonal)` too small. For a bone whose surface is not
/// closed, whose signed distance jumps away from the surface, it is the depth of a point, but perhaps not the deepest.
///
/// A triangle counts against a bone when none of its nodes is carried by that bone and at least one node is free: what
/// is attached to a bone lies in it by intention, with the triangles around, and would hide all else. Free nodes count
/// always, so the depth is never below that of the deepest of them.
class SurfaceDepthMeter {
 public:
  static constexpr double relative_tolerance = 1e-3;
  static constexpr double absolute_tolerance = 1e-6;

  /// `carriers`: for every node the bone that carries it, -1 for a free node.
  SurfaceDepthMeter(std::span<const Triangle> triangles, std::span<const int> carriers, int bones);

  /// `truth`: what `referee.judge` answered last, for these poses and positions (finite; world frame) and all free
  /// nodes. Deterministic; what is kept from earlier calls makes a call faster, and changes the answer only within the
  /// tolerance.
  DeepestSurfacePoint measure(const Referee& referee, std::span<const RigidMotion> poses,
                              std::span<const Vec3> positions, std::span<const Contact> truth);

  /// Questions to the trees in the last call: closest points, and triangles tested for an intersection.
  [[nodiscard]] long last_queries() const { return m_queries; }

  [[nodiscard]] std::size_t bytes() const;

 private:
  /// What is known of one triangle's centroid and one bone.
  struct Memory {
    Vec3 point_m = Vec3::Zero();  ///< where it was when it was last looked at, relative to the tree's centre
    double signed_distance_m = 0;
    int place = -1;  ///< of the closest triangle of the bone; -1: nothing is known
  };
  /// A triangle or a part of one, relative to the tree's centre, and a point whose side of the surface is known.
  struct Part {
    Vec3 a, b, c;
    Vec3 known_m;
    bool known = false;
    bool known_inside = false;
    int place = -1;  ///< a triangle of the bone that is near
  };

  void start_where_it_was_deepest(const Referee& referee, std::span<const RigidMotion> poses,
                                  std::span<const Vec3> positions);
  void measure_bone(int bone, const Referee& referee, const RigidMotion& pose, std::span<const Vec3> positions);
  [[nodiscard]] double bound_from_nodes(const Triangle& triangle) const;
  void search(const RefereeTree& tree, int bone, int triangle, const Part& whole, Memory& memory);
  [[nodiscard]] bool clear_when_moved(const RefereeTree& tree, const Part& part, const Vec3& way, double way_m);
  [[nodiscard]] double limit_m(const RefereeTree& tree) const;

  std::vector<Triangle> m_triangles;
  std::vector<std::vector<int>> m_counting;     // by bone: the triangles that count against it
  std::vector<std::vector<Memory>> m_memories;  // by bone, by place in m_counting
  std::vector<int> m_carriers;
  DeepestSurfacePoint m_best;
  Vec3 m_best_rest_m = Vec3::Zero();   // rest frame of its bone; where it is in a triangle
  Vec3 m_best_weights = Vec3::Zero();  // its barycentric coordinates there
  long m_queries = 0;
  // Scratch memory, kept so that a frame allocates nothing.
  std::vector<Vec3> m_rest;       // nodes, relative to the tree's centre
  std::vector<double> m_least_m;  // lower bounds of their signed distances
  std::vector<char> m_inside;
  std::vector<Part> m_parts;
};

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/referee/referee.hpp"

namespace musclebench {

/// The deepest point of the muscle's surface inside a bone.
struct DeepestSurfacePoint {
  double depth_m = 0;  ///< 0: no point inside a bone was found
  /// No point of the surface is deeper. It exceeds the depth by the tolerance alone unless the budget was spent.
  double bound_m = 0;
  bool complete = true;  ///< whether the budget sufficed
  int bone = -1;
  int triangle = -1;            ///< of the muscle; -1 where the point is a node
  Vec3 point_m = Vec3::Zero();  ///< world
};

/// Of each node the depth of the deepest point of the triangles around it, 0 where none is inside a bone.
struct DepthsAroundNodes {
  std::vector<double> depths_m;
  bool complete = true;  ///< whether the budget sufficed; else they may be deeper
};

/// Finds how deep the muscle's surface, not only its nodes, is inside the bones: all nodes can be outside while a
/// bone's ridge cuts through a face.
///
/// Branch and bound over the triangles, best first (reports/performance/surface_depth.md derives the bounds). The
/// answer is the depth of a point of the surface, so never too large, and at most `relative_tolerance * depth +
/// absolute_tolerance * (the bone's diagonal)` too small, unless the budget is spent before. For a bone whose surface
/// is not closed, whose signed distance jumps away from the surface, it is the depth of a point, but perhaps not the
/// deepest.
///
/// A triangle counts against a bone when none of its nodes is carried by that bone and at least one node is free: what
/// is attached to a bone lies in it by intention, with the triangles around, and would hide all else. Free nodes count
/// always, so the depth is never below that of the deepest of them.
class SurfaceDepthMeter {
 public:
  static constexpr double relative_tolerance = 1e-3;
  static constexpr double absolute_tolerance = 1e-6;

  /// `carriers`: for every node the bone that carries it, -1 for a free node. `left_out`: of every bone, whether it is;
  /// none: no bone is.
  SurfaceDepthMeter(std::span<const Triangle> triangles, std::span<const int> carriers, int bones,
                    std::span<const char> left_out = {});

  /// `truth`: the result of the last `referee.judge`, for these poses and positions (finite; world frame) and all free
  /// nodes, without those in bones that are left out. `budget`: of work, in the unit of RefereeTree; where it is spent,
  /// `bound_m` covers the rest. Deterministic; caches from earlier calls make a call faster, and change the answer only
  /// within tolerance and bound.
  DeepestSurfacePoint measure(const Referee& referee, std::span<const RigidMotion> poses,
                              std::span<const Vec3> positions, std::span<const Contact> truth,
                              long budget = std::numeric_limits<long>::max());

  /// For pictures. Parameters as of `measure`, whose tolerances hold for each triangle, and whose answers stay the same
  /// bits. Where the budget is spent, points that are known so far count.
  DepthsAroundNodes measure_around_nodes(const Referee& referee, std::span<const RigidMotion> poses,
                                         std::span<const Vec3> positions, std::span<const Contact> truth,
                                         long budget = std::numeric_limits<long>::max());

  /// Work of the last call, in the unit of RefereeTree.
  [[nodiscard]] long last_work() const { return m_work; }

  [[nodiscard]] std::size_t bytes() const;

 private:
  /// Result of the last query of one triangle's centroid and one bone.
  struct TriangleCache {
    Vec3 point_m = Vec3::Zero();  ///< the centroid's position then, relative to the tree's centre
    double signed_distance_m = 0;
    int slot = -1;  ///< of the closest triangle of the bone; -1: not queried yet
  };
  /// A triangle or a part of one, relative to the tree's centre, and a point whose side of the surface is known.
  struct Part {
    Vec3 a, b, c;
    Vec3 known_m = Vec3::Zero();
    double known_steady_m = 0;  ///< see SurfaceWinding; 0: no side is known
    bool known_inside = false;
    bool whole = true;    ///< a triangle, not a part of one
    double bound_m = 0;   ///< no point of it is deeper
    double excess_m = 0;  ///< the bound without the absolute tolerance, by which parts at several bones compare
    int bone = -1;
    int index = -1;  ///< in m_counting of the bone
    int slot = -1;   ///< of a triangle of the bone that is near
  };

  void start_where_it_was_deepest(const Referee& referee, std::span<const RigidMotion> poses,
                                  std::span<const Vec3> positions);
  std::size_t take_depths(int bone, std::span<const Contact> truth, std::size_t first);
  void place_nodes(int bone, const Referee& referee, const RigidMotion& pose, std::span<const Vec3> positions);
  void collect_parts(int bone, const RefereeTree& tree);
  [[nodiscard]] Part whole_part(int bone, int index) const;
  void refine_parts(const Referee& referee, long budget);
  void take_side_from_nodes(const RefereeTree& tree, const Triangle& nodes, Part& part) const;
  [[nodiscard]] double bound_from_nodes(const Triangle& triangle) const;
  [[nodiscard]] double bound_from_cache(const Part& part, const TriangleCache& cache, double rounding_m) const;
  void push(Part part, const RefereeTree& tree);
  void refine(const Part& part, const RefereeTree& tree);
  void split(const Part& part, const RefereeTree& tree, const Part& facts, double signed_distance_m);
  [[nodiscard]] bool clear_when_moved(const RefereeTree& tree, const Part& part, Vec3 direction, double distance_m);
  [[nodiscard]] double limit_m(const RefereeTree& tree) const;

  std::vector<Triangle> m_triangles;
  std::vector<std::vector<int>> m_counting;          // by bone: the triangles that count against it
  std::vector<std::vector<TriangleCache>> m_caches;  // by bone, by index in m_counting
  std::vector<int> m_carriers;
  DeepestSurfacePoint m_best;
  Vec3 m_best_rest_m = Vec3::Zero();       // rest frame of its bone; where it is in a triangle
  Vec3 m_best_out_of_bone = Vec3::Zero();  // unit, rest frame: from there to the closest point of the surface
  Vec3 m_best_weights = Vec3::Zero();      // its barycentric coordinates there
  long m_work = 0;
  // Scratch memory, kept so that a frame allocates nothing.
  std::vector<Vec3> m_rest;       // nodes, relative to the tree's centre
  std::vector<double> m_least_m;  // lower bounds of their signed distances
  std::vector<double> m_depth_m;  // of the nodes, in one bone; 0: not inside
  std::vector<Part> m_parts;      // a heap, the one with the largest excess first
};

}  // namespace musclebench

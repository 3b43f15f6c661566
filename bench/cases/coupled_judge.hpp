#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/effects/effect_registry.hpp"
#include "core/measure/bone_vertex_depth.hpp"
#include "core/measure/crossings.hpp"
#include "core/measure/depth_histogram.hpp"
#include "core/measure/edge_stretch.hpp"
#include "core/measure/outcome.hpp"
#include "core/measure/passing_tracker.hpp"
#include "core/measure/ring_meter.hpp"
#include "core/measure/step_record.hpp"
#include "core/measure/surface_depth.hpp"
#include "core/measure/tunnelling_tracker.hpp"
#include "core/referee/muscle_referee.hpp"
#include "core/referee/referee.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// Of the pairs of the scene that touch.
JudgedMuscles judged_muscles_of(const Scene& scene);

/// Whether triangles that pass through others are looked for after a frame.
enum class CrossingTest { where_budget_allows, always };

/// Looks for the depth of bones whose limit is lower than that of others, because they are thin: the deepest point of
/// all may be in a thick bone and within its limit. Bones whose limits differ by less than a factor of two are looked
/// at together, so that a depth of up to twice its limit may hide.
class ThinBones {
 public:
  ThinBones(const Scene& scene, std::span<const int> carriers);

  [[nodiscard]] bool are_there() const { return !m_groups.empty(); }
  /// Parameters as of SurfaceDepthMeter::measure; fills in the record's figures of thin bones: of all groups the depth
  /// that is the largest part of its limit.
  void measure(const Referee& referee, std::span<const RigidMotion> poses, std::span<const Vec3> positions,
               std::span<const Contact> truth, long budget, std::span<const Body> bodies, StepRecord& record);
  [[nodiscard]] long last_work() const { return m_work; }

 private:
  struct Group {
    double limit_m = 0;          ///< the smallest of its bones
    std::vector<char> left_out;  ///< by bone
    SurfaceDepthMeter surface;
    BoneVertexDepthMeter vertices;
  };
  std::vector<Group> m_groups;
  std::vector<Contact> m_truth;
  long m_work = 0;
};

/// What the truth says of a coupled run, frame by frame: how deep muscles and bones are in each other, and muscles that
/// touch in one another, which triangles pass through others, which nodes went through a bone, which are held for
/// nothing, how far a muscle is stretched.
class CoupledJudge {
 public:
  /// `simulation` has not made a frame yet. `threads`: a frame's budget is divided by it.
  /// `declared_missed_m`: of a bone, how deep the contacts may be that its backend declares that it misses
  /// (AnswerBound); infinite counts as nothing declared. Asked only where a contact was missed. `effort`: times the
  /// usual budget.
  CoupledJudge(const Scene& scene, std::span<const BoundNode> bound_nodes, const Simulation& simulation,
               int threads = 1, std::function<double(int bone)> declared_missed_m = {}, long effort = 1);

  /// Fills in the judged figures of `record` after a frame, whose last detection was `detection`.
  void judge(const Simulation& simulation, const LastDetection& detection, StepRecord& record,
             CrossingTest crossings = CrossingTest::where_budget_allows);

  /// Only follows the nodes through a frame: fills in their depths and which passed through what. A tenth of the work
  /// of `judge`; between two frames that are neither judged nor followed paths count as straight.
  void follow(const Simulation& simulation, StepRecord& record);

  /// Of every node, m: > 0 inside a bone, its largest; 0 for free and bound nodes.
  [[nodiscard]] std::vector<double> depths(const Simulation& simulation);

  /// Of every node, m: depth of the deepest point of the surface around it, after `depths` for the same state.
  [[nodiscard]] DepthsAroundNodes surface_depths(const Simulation& simulation);

  /// Of these points, the share that is truly inside a bone.
  [[nodiscard]] double share_inside_bones(std::span<const Vec3> points, std::span<const RigidMotion> poses) const;

  /// Judged before the first frame.
  [[nodiscard]] const StepRecord& at_rest() const { return m_at_rest; }

  /// Of nodes in bones at the ends of the frames judged so far, over the contacts of the last detections.
  [[nodiscard]] const DepthHistogram& contact_depths() const { return m_contact_depths; }

  /// Whose crossings are judged.
  [[nodiscard]] std::span<const CrossingPair> crossing_pairs() const { return m_crossings.pairs(); }

  /// Work in the unit of RefereeTree that a frame may take, what the last one took, and what nodes took of that.
  [[nodiscard]] long budget() const { return m_budget; }
  [[nodiscard]] long last_work() const { return m_work; }
  [[nodiscard]] long last_node_work() const { return m_node_work; }
  /// What looking for crossings took beside that after the last frame; 0: it was left out.
  [[nodiscard]] long last_crossing_work() const { return m_crossing_work; }

 private:
  void judge_bodies(const Simulation& simulation, std::span<const Contact> in_bones,
                    std::span<const Contact> in_muscles, StepRecord& record);
  void judge_nodes(const Simulation& simulation, StepRecord& record);
  void judge_misses(const LastDetection& detection, StepRecord& record) const;
  void judge_crossings(const Simulation& simulation, CrossingTest test, StepRecord& record);
  void judge_surfaces_in_muscles(const Simulation& simulation, StepRecord& record);
  /// Of `CrossingMeter::pairs`, by two muscles in either order.
  [[nodiscard]] std::size_t muscle_pair(const DeepBodies& bodies) const;
  void raise_depth(StepRecord& record, const DeepBodies& bodies, double depth_m) const;

  Referee m_referee;
  std::optional<MuscleReferee> m_muscle_referee;  // where muscles touch
  SurfaceDepthMeter m_surface;
  BoneVertexDepthMeter m_bone_vertices;
  CrossingMeter m_crossings;
  std::optional<PassingTracker> m_passing;  // where muscles touch
  std::vector<Triangle> m_triangles;
  std::vector<Contact> m_in_muscles;  // of the frame
  ThinBones m_thin_bones;
  TunnellingTracker m_tunnelling;
  EdgeStretchMeter m_stretch;
  RingMeter m_rings;
  std::vector<Body> m_bodies;  // where there are several
  std::vector<EdgeStretchMeter> m_stretch_of_bodies;
  DepthHistogram m_contact_depths;
  StepRecord m_at_rest;
  std::vector<Body> m_all_bodies;
  double m_smallest_diagonal_m;
  std::function<double(int)> m_declared_missed_m;
  double m_floor_m;  // of a movement that counts, for stuck nodes
  long m_budget;
  long m_work = 0;       // of the last frame
  long m_node_work = 0;  // of that, what judging and following the nodes took
  long m_crossing_work = 0;
  long m_crossing_credit = 0;    // what frames have left for the next test for crossings
  long m_crossing_estimate = 0;  // what the last one took
  std::vector<Contact> m_truth;
};

/// Work in the unit of RefereeTree that judging a frame may take: 18 times the time of the frame itself on `threads`,
/// which is estimated from below from the size of the scene alone, so that the same case is judged alike on any
/// machine; some 2 ms at least. The nodes are always judged, at most one distance and one winding number a bone and
/// detection, and followed; bones' vertices and then the muscle's surface take what is left. An eighth of the budget is
/// for each of the two even where nodes leave nothing, and each may exceed its share by what it looks at last.
/// Triangles that pass through others are looked for in whole frames, as soon as an eighth of each frame's budget, or
/// what it has left, adds up to the work of the last such test: in each frame of an anatomical scene.
long judging_budget(const Scene& scene, int threads = 1);

}  // namespace musclebench

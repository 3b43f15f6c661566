#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/measure/crossings.hpp"
#include "core/measure/depth_limit.hpp"
#include "core/measure/step_record.hpp"

namespace musclebench {

/// What a run's figures are compared with, and what words about them name.
struct MuscleAtRest {
  std::vector<double> volumes_m3;   ///< of each muscle, of either sign
  std::vector<bool> are_open = {};  ///< by muscle: its surface encloses no volume; empty: none is
  double pressure = 1;              ///< target volume over that at rest, see the effect `volume`
  double mean_edge_length_m = 0;    ///< 0: unknown
  int free_nodes = 0;
  int triangles = 0;
  std::vector<CrossingPair> crossing_pairs;      ///< whose crossings are judged; none where nobody judges
  std::vector<int> crossings;                    ///< of each before the first frame
  std::vector<double> depths_in_muscles_m = {};  ///< as StepRecord has them
  std::vector<SharedFaces> shared_faces;         ///< of each two muscles that have some
  std::vector<MuscleSize> muscles;
  std::vector<BoneSize> bones;
  std::vector<std::pair<int, int>> touching;  ///< muscles whose contact the scene asks for, the lower index first
  std::vector<std::string> effects;           ///< of the scene, by name
  std::vector<std::string> rings = {};        ///< names of its retinacula
  std::string backend = {};
  std::optional<DepthStatistics> depth;        ///< of the free nodes in the bones, before the first frame
  std::optional<DepthStatistics> in_muscles;   ///< of nodes in other muscles; nothing where no muscles touch
  DeepBodies depth_bodies, in_muscles_bodies;  ///< of the deepest of each

  /// Whether the scene asks for contact between the two muscles.
  [[nodiscard]] bool touch(int one, int other) const;
};

/// Of a pair, in the frame with the most of them.
struct MostCrossings {
  int triangles = 0;
  int frame = 0;  ///< the first with so many; 0: there were none
  double angle_deg = 0;
};

/// When a figure was largest.
struct Moment {
  int frame = 0;
  double angle_deg = 0;  ///< of the bone that turns most
};

/// A depth in a bone or in another muscle, of all frames the one that is the largest part of its limit.
struct WorstDepth {
  double depth_m = 0;
  DepthLimit limit = {};
  DeepBodies bodies = {};
  Moment when = {};
  bool is_bone_vertex = false;  ///< that of a bone's vertex in the muscle
  double node_depth_m = 0;      ///< of the deepest node in that frame

  [[nodiscard]] bool is_beyond() const { return !(depth_m <= limit.depth_m); }
};

/// What a backend's answers did to the muscle, over a whole run. A figure is missing where nothing was measured that it
/// could be made from.
struct Outcome {
  /// Over the judged frames, of the deepest node in a frame: the largest, and the 99th percentile (percentile_index).
  std::optional<double> max_depth_m, p99_depth_m;
  /// 99th percentile of node depth over all contacts of the judged frames, see DepthHistogram. run_case fills it in.
  std::optional<double> p99_contact_depth_m;
  /// The same for the deepest point of a frame, of the muscle's surface in a bone or of a bone's vertex in the muscle.
  std::optional<double> max_surface_depth_m, p99_surface_depth_m;
  /// No such point is deeper in any frame; larger than what was found where the Referee's budget was spent.
  std::optional<double> max_surface_depth_bound_m;
  /// |V - p V0| / |p V0| of the muscle's volume V, that at rest V0 and the pressure p: the largest over all frames,
  /// without the first ones in which a muscle under pressure still comes closer to its target; and after the last one.
  std::optional<double> max_volume_error, final_volume_error;
  std::optional<bool> turned_inside_out;  ///< whether the volume had the other sign than at rest after some frame
  /// Largest over the judged frames, see EdgeStretch.
  std::optional<double> max_edge_stretch, p99_edge_stretch;
  std::optional<int> tunnelled_nodes;      ///< most at the end of one frame
  std::optional<int> stuck_nodes;          ///< most in one frame
  std::optional<int> nodes_inside_at_end;  ///< after the last frame, if that was judged
  std::optional<int> nodes_inside_at_rest;
  std::optional<double> depth_at_rest_m;  ///< of the deepest of them
  /// Of the deepest node in another muscle: the largest over the frames, and before the first; most nodes in one frame.
  std::optional<double> max_muscle_depth_m, muscle_depth_at_rest_m;
  std::optional<int> nodes_inside_muscles;
  /// Most in one of the frames that were tested, and before the first one.
  std::optional<int> self_intersecting_triangles, self_intersecting_triangles_at_rest;
  /// The same through bones and other muscles: see StepRecord.
  std::optional<int> bone_crossings, bone_crossings_at_rest, muscle_crossings, muscle_crossings_at_rest;
  std::vector<MostCrossings> crossings;                       ///< by MuscleAtRest::crossing_pairs
  std::vector<MostCrossings> beyond_rest;                     ///< the same of StepRecord::beyond_rest
  int crossing_frames = 0;                                    ///< that were tested for crossings
  std::optional<WorstDepth> worst_depth, worst_muscle_depth;  ///< where sizes are known and something is deep
  Moment when_volume, when_p99_stretch, when_max_stretch, when_tunnelled, when_stuck;
  std::optional<double> max_muscle_surface_depth_m;  ///< largest of StepRecord::muscle_surface_depth_m
  std::optional<int> passed_nodes;  ///< most that went through another muscle between two judged frames
  Moment when_passed;
  RingEscape ring_escape;  ///< the largest share of the judged frames
  Moment when_out_of_ring;
  int volume_muscle = 0;  ///< whose volume was off most
  /// Over all judged frames: contacts that were true in their last detections, those that were missed and deeper than
  /// the backend declares that it may miss, and the deepest of them.
  std::optional<long> true_contacts, missed_beyond;
  double max_missed_m = 0;
  int open_judgements = 0;       ///< frames for which the Referee's budget did not suffice
  Nanoseconds collision_ns = 0;  ///< of the backend with bones: update, detect and respond, sum over the run
  Nanoseconds loop_ns = 0;       ///< sum of the frames
};

Outcome outcome_of(std::span<const StepRecord> records, const MuscleAtRest& rest);

}  // namespace musclebench

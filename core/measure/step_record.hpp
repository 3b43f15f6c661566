#pragma once

#include <limits>
#include <numeric>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "core/base/column.hpp"
#include "core/measure/edge_stretch.hpp"
#include "core/measure/ring_meter.hpp"
#include "core/pbd/simulation.hpp"
#include "core/referee/contact_comparison.hpp"

namespace musclebench {

/// In order.
inline double sum_of(std::span<const double> values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// Which muscle is deep in what, by indices; -1: none is.
struct DeepBodies {
  int muscle = -1;
  int other = -1;  ///< a bone, or another muscle
};

/// What a frame left of one muscle of several.
struct MuscleRecord {
  int contacts = 0;            ///< with bones, answered by the last detection
  DepthStatistics in_bones;    ///< judged
  DepthStatistics in_muscles;  ///< judged, where muscles touch
  double volume_m3 = 0;
  EdgeStretch edge_stretch;  ///< judged
};

/// What a frame left of one pair of a muscle and a bone, or of two muscles that touch.
struct PairRecord {
  std::string muscle;
  std::string other;
  std::optional<Nanoseconds> detect_ns;  ///< over the frame's steps; nothing: the backend does not say
  int contacts = 0;              ///< answered by the last detection: nodes in the bone, or of either in the other
  std::optional<int> crossings;  ///< triangles of the muscle that pass through the other; nothing: not tested
};

/// One row of frames.csv. Figures that are not known stay empty in the file.
struct StepRecord {
  int frame = 0;         ///< 1-based
  double angle_deg = 0;  ///< of the bone that turns most
  bool warm_up = false;
  StageTimes times;
  int contacts = 0;                           ///< answered by the last detection of the frame
  std::optional<int> muscle_contacts;         ///< of the last detection between muscles; nothing where none touch
  std::optional<DepthStatistics> in_muscles;  ///< true depths of nodes in other muscles, at the frame's end
  bool judged = false;                        ///< whether the Referee judged this frame
  DepthStatistics depth;                      ///< at the frame's end
  ContactDifference difference;               ///< of the last detection
  /// At the frame's end: see SurfaceDepthMeter and BoneVertexDepthMeter. NaN: not measured. The bounds are larger by
  /// more than the tolerance only where the Referee's budget did not suffice, and then the judgement is not complete.
  double surface_depth_m = std::numeric_limits<double>::quiet_NaN();
  double surface_depth_bound_m = std::numeric_limits<double>::quiet_NaN();
  double bone_vertex_depth_m = std::numeric_limits<double>::quiet_NaN();
  double bone_vertex_depth_bound_m = std::numeric_limits<double>::quiet_NaN();
  /// Of the deepest node in a bone and in a muscle, point of the surface, and bone vertex.
  DeepBodies depth_bodies, in_muscles_bodies, surface_bodies, bone_vertex_bodies;
  /// The deepest point of a muscle in a thin bone or of a thin bone in a muscle, see ThinBones; a thicker bone in which
  /// the muscle is deeper doesn't hide it. 0 where there is none.
  double thin_bone_depth_m = 0;
  DeepBodies thin_bone_bodies;
  bool thin_bone_is_vertex = false;
  bool judgement_complete = true;
  int true_contacts = 0;    ///< of the last detection
  int missed_beyond = 0;    ///< of them missed and deeper than the backend declares that it may miss
  double max_missed_m = 0;  ///< depth of the deepest of these
  /// Deepest point of a muscle's surface in another that it touches; NaN: not tested in this frame.
  double muscle_surface_depth_m = std::numeric_limits<double>::quiet_NaN();
  DeepBodies muscle_surface_bodies;
  /// Of each pair of CrossingMeter::pairs of two muscles that touch: the deepest point of one in the other, of nodes
  /// alone where surfaces were not tested; 0 for other pairs. None: no muscles touch.
  std::vector<double> depths_in_muscles_m;
  std::optional<int> passed_nodes;  ///< went through another muscle since the last judged frame, see PassingTracker
  int tunnelled_nodes = 0;          ///< that went through a bone and have not come back, see TunnellingTracker
  int stuck_nodes = 0;              ///< in this frame, see count_stuck_nodes
  EdgeStretch edge_stretch;         ///< at the frame's end
  RingEscape ring_escape;           ///< of tendons from their retinacula, at the frame's end
  /// Triangles of muscles that pass through bones, through other muscles (nothing with one muscle) and through their
  /// own muscle at the frame's end; nothing where that was not tested.
  std::optional<int> bone_crossings, muscle_crossings, self_intersecting_triangles;
  std::vector<int> crossings;         ///< the same by pair, see CrossingMeter; none: not tested
  std::vector<int> beyond_rest;       ///< of these beyond the ones at rest, see CrossingMeter::beyond_rest
  std::vector<double> volumes_m3;     ///< of each muscle
  std::vector<MuscleRecord> muscles;  ///< of each of several; none for one
  std::vector<PairRecord> pairs;      ///< of several muscles
  std::size_t resident_bytes = 0;     ///< 0: unknown
  long involuntary_switches = 0;      ///< while the frame was timed, see ContextSwitches
  Nanoseconds judging_ns = 0;         ///< taken by the Referee, outside of the frame
};

/// The columns of a run's frames.csv. Those that are named EFFECT_ns and STAGE_ns stand for one column an effect and a
/// contact stage, and have no cell.
std::span<const Column<StepRecord>> run_columns();
inline constexpr std::string_view effect_column = "EFFECT_ns";
inline constexpr std::string_view stage_column = "STAGE_ns";

/// Writes the header and one line a record. The names are those of the simulation, in its order. Numbers read back
/// to the same bits; a figure that is unknown or not finite is an empty cell.
void write_frames_csv(std::ostream& out, const std::vector<std::string>& effect_names,
                      const std::vector<std::string>& stage_names, const std::vector<StepRecord>& records);

}  // namespace musclebench

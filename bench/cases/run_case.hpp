#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/cases/build_backend.hpp"
#include "bench/cases/fibre_watch.hpp"
#include "bench/cases/forces/force_watch.hpp"
#include "core/base/machine_state.hpp"
#include "core/measure/outcome.hpp"
#include "core/measure/step_record.hpp"
#include "core/recording/recording.hpp"

namespace musclebench {

/// One case and how its run is measured.
struct RunCase : Case {
  int warm_up_frames = 2;     ///< recorded and marked
  bool judge = true;          ///< whether the Referee judges
  bool keeps_shared = false;  ///< structures over bones (Bone::shared), for the next run of the scene
  long judging_effort = 1;    ///< times the budget that a frame's judgement has in other runs
  /// Whether it looks for triangles through others in every frame that it judges, and as closely as on one thread: what
  /// is wanted holds or does not, however the run is made. Else where a frame's budget allows.
  bool judges_wishes = false;
  /// Frames that it judges, ascending; empty: all. In the others it only follows the nodes.
  std::vector<int> judged_frames = {};
  /// Asked after each frame. True ends the run, with status `interrupted`.
  std::function<bool(const StepRecord& frame, const MuscleAtRest& rest)> has_seen_enough = {};
  std::vector<int> snapshots = {};  ///< frames (0: rest) whose shape is kept, ascending
  /// Without a judge, who counts them anyway: at rest, in the frames of `snapshots` and after the last frame.
  bool count_self_intersections = false;
  bool keep_surface_depths = true;  ///< of the snapshots, by the judge; takes up to 0.25 s each
  bool forces = false;              ///< whether the forces of every frame are told
};

/// The shape of the muscle at the end of a frame.
struct Snapshot {
  int frame = 0;
  double angle_deg = 0;
  std::vector<Vec3> positions;
  std::vector<double> depths_m;          ///< a node: > 0 inside a bone; 0 for free and bound nodes; empty: not judged
  std::vector<double> surface_depths_m;  ///< a node: of the deepest point around it; 0: outside; empty: not kept
  bool surface_is_complete = true;       ///< whether the budget sufficed for them
  std::vector<RigidMotion> bone_poses;
  NodeForces contact = {};                   ///< empty where no forces are told
  std::vector<BoneVertexRow> on_bones = {};  ///< what muscles do to bones; empty where no forces are told
  std::vector<std::vector<Vec3>> fibres;     ///< of each muscle, fibre after fibre; none where none are followed
};

/// What a stage of the run promises and could not hold.
struct GaveUp {
  std::string stage;
  int frame = 0;  ///< in which that was first so
  std::string why;
};

struct RunResult {
  std::string status = "ok";       ///< ok, suspect (beyond an OutcomeLimit), diverged or interrupted
  std::string status_detail;       ///< sentences: why it is not ok, and what may mend it
  std::vector<std::string> notes;  ///< what a reader should know beside that
  MuscleAtRest rest;
  std::vector<GaveUp> gave_up;  ///< at most one a stage
  Outcome outcome;
  MachineState machine;
  std::vector<std::string> effect_names;
  std::vector<std::string> stage_names;
  std::vector<StepRecord> records;
  std::vector<Snapshot> snapshots;
  std::vector<Vec3> start_positions;  ///< before the first frame
  std::vector<Vec3> end_positions;    ///< after the last; empty where the run ended before
  std::vector<FibreFrame> fibres;     ///< of rest and each frame, where the scene asks for them
  std::vector<FollowedFibres> followed_fibres;
  std::string fibres_refused;  ///< why there are none where they were asked for and could be left out
  std::size_t fibre_bytes = 0;
  std::vector<ForceRow> forces;    ///< of every frame, where they are asked for
  ForceObstacles force_obstacles;  ///< why some are missing
  std::vector<BoundNode> bound_nodes;
  std::size_t structure_bytes = 0;
  std::size_t muscle_structure_bytes = 0;  ///< of what detects contacts between muscles
  std::size_t face_structure_bytes = 0;    ///< of what answers for faces (`--for faces`)
  Nanoseconds face_build_ns = 0;           ///< to build that; of a bone that is met late it is within a frame, too
  std::vector<StructureError> structure_errors;  ///< of backends that approximate
  std::vector<PrunedResult> pruned;
  StructureOrigin structures = {};
  Nanoseconds build_ns = 0;             ///< building or loading
  Nanoseconds wall_ns = 0;              ///< from the first frame to the last, with judging
  Nanoseconds cpu_before_ns = 0;        ///< of all threads of the process before the first frame
  Nanoseconds cpu_after_ns = 0;         ///< the same after the last frame
  std::size_t memory_before_bytes = 0;  ///< resident, without the Referee and huge-page padding
  std::size_t memory_after_bytes = 0;   ///< the same
  std::size_t huge_page_bytes = 0;      ///< padding of huge pages; in none of the others but the peak
  std::size_t memory_peak_bytes = 0;    ///< of the whole process
  std::size_t referee_bytes = 0;        ///< resident memory of judging, of following fibres and of snapshots
  std::string state_hash;               ///< of all positions and velocities at the end
  /// Of a run that diverged: the collision steps of the last whole frames before, up to frames_kept_before_divergence.
  std::vector<RecordedStep> last_steps = {};
};

/// What a reader of the run should know beside the warnings of its scene: effects that wait for contacts that its
/// backends do not find, and wishes that nobody judges.
std::vector<SceneWarning> warnings_of_run(const RunCase& run);

/// Whether an effect of the scene keeps its fibres under tension.
bool pulls_fibres(const Scene& scene);

/// Runs the case. `report` is called after each frame, `report_build` now and then before the first. A run that blows
/// up ends with status `diverged` in the substep that loses a node; one that `is_stopped` stops, asked in each substep,
/// with status `interrupted` and the rows of its whole frames; one with an outcome beyond a limit (outcome_limits) is
/// `suspect`.
/// Throws InputError when the backend's parameters do not fit the scene.
RunResult run_case(const RunCase& run, const std::function<void(int frames_done)>& report,
                   const std::function<void(double share)>& report_build = {},
                   const std::function<bool()>& is_stopped = {});

}  // namespace musclebench

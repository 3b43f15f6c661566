#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/cases/build_backend.hpp"
#include "bench/cases/muscle_replay.hpp"
#include "core/base/machine_state.hpp"
#include "core/measure/surface_offset.hpp"
#include "core/recording/frame_source.hpp"

namespace musclebench {

/// One backend replayed on the detections of a recording.
struct ReplayCase : Case {
  RecordingFile recording = {};  ///< none for frames that were never in a file
  int warm_up_frames = 2;        ///< of those replayed; recorded and marked
  int stride = 1;                ///< every so many-th frame is replayed, and the last
  double band_m = 0.01;          ///< errors are measured, and offsets searched for, so far from the surface
  bool judge = true;             ///< whether the Referee judges every answer
};

struct ReplayResult {
  std::string status = "ok";  ///< ok, suspect (answers that are off by more than is declared) or nondeterministic
  std::string status_detail;
  std::vector<ReplayRecord> records;
  std::optional<Accuracy> accuracy;           ///< over all frames
  std::vector<Accuracy> accuracy_of_muscles;  ///< the same of each muscle; empty where there is but one
  /// Where the backend believes the bones' surfaces are; nothing where nobody judged, or where it can't be asked about
  /// single nodes.
  std::optional<SurfaceOffsets> offsets;
  std::string contact_hash;   ///< of all contacts of all steps, in their order, to the last bit
  std::string queries_hash;   ///< of all poses and positions that were asked about, in the same way
  AnswerBound declared = {};  ///< the largest of all bones
  std::size_t structure_bytes = 0;
  std::vector<PrunedResult> pruned;
  StructureOrigin structures = {};
  Nanoseconds build_ns = 0;             ///< building or loading
  Nanoseconds wall_ns = 0;              ///< of all passes
  MachineState machine;                 ///< in the timed pass
  std::optional<MuscleReplay> muscles;  ///< nothing where none touch or the recording does not tell
};

/// Whether contact between muscles is replayed, too.
bool replays_muscles(const ReplayCase& replay, const RecordingHeader& header);

/// How many frames are fed to backends, over all passes.
int replayed_frames(const ReplayCase& replay, const RecordingHeader& header);

/// Feeds the recording to the backend, twice: a timed pass, and one that is judged, where every step must get the same
/// contacts. After that the backend is asked about single nodes around a sample of the true contacts of each frame's
/// last step (SurfaceOffsets). The response works on copies: its result is not fed back. `report` is called after each
/// frame of each pass. Throws InputError when the backend's parameters do not fit the scene. Where muscles touch what
/// detects that is fed after that (replay_muscles), so that neither disturbs the other's caches.
///
/// Frames are read one at a time, between the timed regions. With all of them in memory first, detection takes the same
/// time, and the backtracking response 40 % longer than it should: the starts of the substeps, which the loop has just
/// written, are then cold.
ReplayResult replay_case(const ReplayCase& replay, FrameSource& recording,
                         const std::function<void(int frames_done)>& report);

}  // namespace musclebench

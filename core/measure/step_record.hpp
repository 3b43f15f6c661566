#pragma once

#include <limits>
#include <ostream>
#include <string>
#include <vector>

#include "core/pbd/simulation.hpp"
#include "core/referee/contact_comparison.hpp"

namespace musclebench {

/// One row of frames.csv. Figures that are not known stay empty in the file.
struct StepRecord {
  int frame = 0;         ///< 1-based
  double angle_deg = 0;  ///< of the bone that turns most
  bool warm_up = false;
  StageTimes times;
  int contacts = 0;              ///< answered by the last detection of the frame
  bool judged = false;           ///< whether the Referee looked at this frame
  DepthStatistics depth;         ///< at the frame's end
  ContactDifference difference;  ///< of the last detection
  /// At the frame's end: see SurfaceDepthMeter and BoneVertexDepthMeter. NaN: not measured.
  double surface_depth_m = std::numeric_limits<double>::quiet_NaN();
  double bone_vertex_depth_m = std::numeric_limits<double>::quiet_NaN();
  int tunnelled_nodes = 0;  ///< that went through a bone and have not come back, see TunnellingTracker
  int stuck_nodes = 0;      ///< in this frame, see count_stuck_nodes
  double volume_m3 = 0;
  std::size_t resident_bytes = 0;  ///< 0: unknown
};

/// Writes the header and one line a record. `effect_names` are those of the simulation, in its order. Numbers read back
/// to the same bits; a figure that is unknown or not finite is an empty cell.
void write_frames_csv(std::ostream& out, const std::vector<std::string>& effect_names,
                      const std::vector<StepRecord>& records);

}  // namespace musclebench

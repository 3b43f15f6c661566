#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/cases/case.hpp"
#include "core/base/scoped_timer.hpp"
#include "core/measure/depth_error.hpp"

namespace musclebench {

/// One backend queried at points around each bone's surface.
struct ProbeCase : Case {
  int points = 20000;  ///< a bone
  std::uint64_t seed = 1;
  double band_m = 2e-3;  ///< the points lie up to this far from the surface
};

/// What came out at one kind of region of one bone.
struct ProbeRow {
  std::string bone;
  std::string region;       ///< smooth, sharp (`SharpFeatures`) or all
  int points = 0;           ///< queried
  int measured_points = 0;  ///< of them inside, or reported so: what the errors are over
  ErrorStatistics errors_m;
  int wrong_side = 0;  ///< points reported that are outside, or not reported that are inside
};

struct ProbedBone {
  std::string name;
  double cell_edge_m = 0;  ///< smallest; 0: the backend has no cells
  double sharp_radius_m = 0;
  int sharp_edges = 0;
  int sharp_vertices = 0;
};

struct ProbeResult {
  std::string status = "ok";  ///< ok, or unsupported where the backend has no point queries
  std::string status_detail;
  std::vector<ProbeRow> rows;
  std::vector<ProbedBone> bones;
  std::size_t structure_bytes = 0;
  StructureOrigin structures = {};
  Nanoseconds build_ns = 0;   ///< building or loading
  Nanoseconds detect_ns = 0;  ///< of all points against all bones
};

/// Queries the backend at points that are spread evenly over each bone's area, each moved along its face's normal:
/// three of four up to `band_m` inwards, one outwards. The truth is the Referee's. The same points for every backend.
/// Throws InputError when the backend's parameters do not fit the scene.
ProbeResult probe(const ProbeCase& what, const std::function<void(int points_done)>& report);

}  // namespace musclebench

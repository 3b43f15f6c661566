#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "backends/sdf/octree/octree_field.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// What an adaptive field has to reach.
struct OctreeSettings {
  /// Of 100 points up to `near_m` from the surface, 99 differ by no more from the exact distance.
  double max_error_m = 5e-5;
  /// 0: 1/200 of the diagonal of the bone's box, 2.3 mm on a thigh bone: a contact that is deeper is resolved by many
  /// steps, and only the last ones show.
  double near_m = 0;
  double margin = 1e-3;          ///< the domain reaches beyond the bone's box at least by this share of its diagonal
  std::size_t memory_bytes = 0;  ///< that building may use; 0: what this machine has
};

/// Called with the share that is done, in [0, 1], never decreasing; from the calling thread.
using BuildProgress = std::function<void(double share)>;

/// Builds the field that reaches the wanted error with few coefficients.
///
/// The target is 99 of 100 points, because the distance has kinks where the surface has edges, and there the error
/// of any polynomial falls only as fast as its cell's edge: refining for the last point there would take most cells of
/// the field. The largest error is reported beside it. The jump across a face between leaves is somewhat larger than
/// the error, so the target is a little below the wanted error: then jumps, too, are within that at 99 of 100 points
/// (on the LHDL pelvis and femur, for 0.05 and 0.2 mm, 99 % of the area of all faces near the surface by 0.88 to 1.01
/// of it).
///
/// How it is met: every leaf has an error indicator, its volume weighted at each of its 27 or 35 samples by the error
/// over the allowed error. Leaves above a threshold are split; where a cubic polynomial lowers the indicator by a tenth
/// of the threshold the others get one. The threshold falls until the error, measured at 10,000 random points that
/// no fit has used (`reference_samples`), is reached. So the errors that are left are those most expensive to reduce.
/// Beyond `near_m`, inside, the allowed error grows by a tenth of the distance beyond; outside the field becomes a
/// lower bound.
///
/// The same bits for any number of threads. Throws InputError (about `max_error_mm` of the bone) where the wanted
/// error is out of all proportion to the bone, or needs more memory than there is, with the error that fits.
OctreeField build_octree(const SignedSurface& surface, const TriangleMesh& mesh, const OctreeSettings& settings,
                         const std::string& bone_name, int threads, const BuildProgress& progress = {});

/// How far from the box of the surface its domain reaches, at most.
double octree_reach_m(const TriangleMesh& mesh, const OctreeSettings& settings);

}  // namespace musclebench

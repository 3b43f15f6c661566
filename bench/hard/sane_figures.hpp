#pragma once

#include <string>
#include <vector>

#include "bench/hard/hard_case.hpp"
#include "bench/hard/moved_scene.hpp"

namespace musclebench {

/// What a muscle that moved has to stay within, whatever a case is about. A case that leaves one out says why
/// (HardCase::left_out_because).
struct SaneBars {
  double volume_error = 0.05;
  double edge_stretch = 2;    ///< the longest edge over its length at rest
  double depth_m = 1e-4;      ///< of the surface in a bone; infinite: not asked for
  double depth_share = 0.01;  ///< the same over the muscle's diagonal: the larger of the two is the bar
  bool passing = true;        ///< whether no triangle may pass through another
  bool status = true;         ///< whether the run has to end with the status ok
};

/// Triangles that pass through bones, through other muscles or through their own muscle; the most after one frame,
/// beyond those at rest (CrossingMeter::beyond_rest).
struct PassingTriangles {
  int bones = 0;
  int muscles = 0;
  int itself = 0;
};

/// Decided by exact predicates (CrossingMeter) for the shapes that the run has kept. A node that contact has put on a
/// surface lies inside by rounding as often as outside, so that what only touches does not count: nodes within 1e-6
/// diagonals of a bone's surface, or within `declared_m`, by which the backend may misplace them, count as outside; of
/// two muscles, and of one with itself, triangles count that still pass once the muscle is drawn in by 1e-6 diagonals.
PassingTriangles passing_triangles(const MovedScene& run, double declared_m);

/// Triangles that pass, nodes on the wrong side, depth of the surface in bones (to its bar comes what the backend
/// declares), volume, longest edge and status of one run. `words` tell it from other runs of the case.
std::vector<HardFigure> sane_figures(const MovedScene& run, const HardRequest& request, const std::string& words = "",
                                     const SaneBars& bars = {});

/// `figures` and after them the sane ones of the run.
std::vector<HardFigure> with_sane_figures(std::vector<HardFigure> figures, const MovedScene& run,
                                          const HardRequest& request, const std::string& words = "",
                                          const SaneBars& bars = {});

}  // namespace musclebench

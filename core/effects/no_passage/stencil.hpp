#pragma once

#include <array>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// How two features of surfaces can touch first: all other contacts of triangles begin with one of these.
enum class StencilKind : unsigned char {
  node_face,  ///< corner 0 against the face of corners 1, 2 and 3
  edge_edge,  ///< the edge of corners 0 and 1 against the edge of corners 2 and 3
};

/// The corners of a stencil, m, in one frame.
using StencilCorners = std::array<Vec3, 4>;

/// The closest points of the two sides of a stencil.
struct StencilGap {
  /// One weight a corner: those of the first side are >= 0 and add up to 1, those of the second are <= 0 and add up
  /// to -1.
  std::array<double, 4> weights = {};
  Vec3 apart = Vec3::Zero();  ///< from the second side's point to the first's, m
  double distance_m = 0;
};

/// The closest points of both sides. Sides without length or area count as segments or points.
StencilGap gap_of(StencilKind kind, const StencilCorners& corners);

/// The same distance, m, without its points.
double distance_of(StencilKind kind, const StencilCorners& corners);

/// Whether both sides stay more than `least_m` apart on straight paths to `end`, along the direction in which `before`
/// has them apart where the paths start. If not, they may or may not.
bool stay_apart(StencilKind kind, const StencilGap& before, const StencilCorners& end, double least_m);

/// `safe_share` ends a motion where less than this share of `least_m` is left above it.
inline constexpr double enough_share = 0.01;

/// The share of a straight motion from `start` to `end`, 0 to 1, that the stencil can surely take before its sides come
/// closer than `least_m`: 1 where they never do. Additive conservative advancement (Li, Kaufman and Jiang 2021,
/// "Codimensional incremental potential contact", section 5.4). What all corners move alike does not count. Sides that
/// begin closer than `least_m` get 0 where they approach.
double safe_share(StencilKind kind, const StencilCorners& start, const StencilCorners& end, double least_m);

}  // namespace musclebench

#pragma once

#include <array>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A ray along a coordinate axis: from its start towards +axis or -axis.
struct AxisRay {
  int axis = 0;         ///< 0, 1, 2: x, y, z
  bool upwards = true;  ///< towards +axis
};

/// How the ray from `start` passes the triangle (a, b, c): +1 leaves through its front, -1 enters through it, 0 misses
/// it. Decided without rounding errors (floating-point filter, then exact expansions, Shewchuk 1997); a ray that meets
/// an edge or a vertex is moved aside infinitesimally, alike for every triangle (simulation of simplicity,
/// Edelsbrunner and Muecke 1990). So the sum over a closed surface is exactly its winding number around `start`, for
/// every start that does not lie on the surface.
int ray_crossing(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& start, AxisRay ray);

/// +1 where p lies in front of the plane of (a, b, c), from which they run counter-clockwise; -1 behind it, 0 on it.
/// Decided without rounding errors.
int plane_side(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p);

/// Whether the segment passes through the triangle (a, b, c): +1 leaves through its front, -1 enters through it, 0
/// misses it. Decided without rounding errors. An end on the triangle's plane counts as in front of it; of two
/// triangles that share an edge which the segment meets, one is crossed. Through a vertex no such promise is made.
int segment_crossing(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& from, const Vec3& to);

using TriangleCorners = std::array<Vec3, 3>;

/// Whether two triangles pass through each other: their insides have a segment in common, at which each lies on both
/// sides of the other. What only touches, or lies in one plane, does not. Decided without rounding errors, by the sides
/// of corners to planes alone (Guigue and Devillers 2003, with strict signs).
bool pass_through_each_other(const TriangleCorners& one, const TriangleCorners& other);

/// Solid angle, over 4 pi, of the strip that the edge a -> b sweeps when it is translated to infinity against the
/// direction of `ray`, seen from `eye`; signed as the strip's spherical triangle (a, b, minus the ray's direction),
/// positive where its back is seen (Van Oosterom and Strackee 1983). Its sign is decided as `ray_crossing` decides
/// sides, so that the crossings of a surface by the ray and the strips of its boundary edges, each a -> b as the
/// triangles run, sum to the surface's generalised winding number: the strips close the surface, and no strip crosses
/// the ray.
double strip_share(const Vec3& a, const Vec3& b, const Vec3& eye, AxisRay ray);

}  // namespace musclebench

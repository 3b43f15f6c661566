#pragma once

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

// Surfaces that are hard to answer about, made by code, in metres and centred on the origin unless said otherwise.

/// A cone of 60 mm on a base of 6 mm: sharper at its tip than any cell of a grid.
TriangleMesh make_spike();

/// A ball with bumps and hollows, no longer convex: every vertex of a sphere of 25 mm moved by up to 40 % of the radius
/// along it. `subdivisions` as in make_sphere.
TriangleMesh make_bumpy_ball(int subdivisions);

/// A square of 100 mm, `thickness_m` thick along z.
TriangleMesh make_plate(double thickness_m);

/// A wing of that thickness that stands on a block of 100 x 100 x 20 mm, its middle at x = 12.3 mm, 20 to 100 mm up: as
/// that of the ilium, thinner than the bone's box lets one see.
TriangleMesh make_winged_block(double thickness_m);

/// `parts` tetrahedra in a row along x, four vertices each and wound outwards, the first 0.4 mm large at 0.1 m: each is
/// `factor` times as large as the one before it and as far from the origin.
TriangleMesh make_shrinking_row(int parts, double factor);

/// The mesh without `triangles` of its triangles that share edges, grown around the one farthest along `direction`.
TriangleMesh with_hole(const TriangleMesh& mesh, int triangles, const Vec3& direction);

/// The same surface, badly meshed: triangles without area, triangles twice, and edges split so that slivers of aspect
/// 1e8 lie along them.
TriangleMesh with_bad_triangles(const TriangleMesh& mesh);

TriangleMesh inside_out(TriangleMesh mesh);
TriangleMesh scaled(TriangleMesh mesh, double factor);
TriangleMesh shifted(TriangleMesh mesh, const Vec3& by_m);

}  // namespace musclebench

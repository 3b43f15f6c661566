#pragma once

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

// Shapes with sharp edges and corners, which contact methods are tested with (Erleben 2018, Methodology for assessing
// mesh-based contact point methods, section 5). Closed, wound outwards, in metres.

/// A cone whose tip is the origin: it stands (`up` = 1) on a base below, or hangs (-1) from one above.
TriangleMesh make_cone(double radius_m, double height_m, int sides, double up);

/// A prism along y whose edge at the origin is sharp; `up` as of a cone.
TriangleMesh make_wedge(double half_width_m, double height_m, double half_length_m, double up);

/// A block below z = 0 with a crack of V shape along y, at its sharp bottom `depth_m` deep.
TriangleMesh make_cracked_block(double half_width_m, double depth_m);

/// A prism along y that stands on two sharp edges 24 mm apart, a notch between them; split twice.
TriangleMesh make_skids(double half_length_m);

/// A U along y, open upwards: walls and floor 8 mm thick about a gap of 14 mm, 30 mm wide and high; split twice.
TriangleMesh make_channel(double half_length_m);

/// A plate below z = 0 with a square hole through its middle, of edges one cell of 12 mm long.
TriangleMesh make_holed_plate();

}  // namespace musclebench

#pragma once

#include "core/mesh/triangle_mesh.hpp"
#include "datasets/synthetic/synthetic_field.hpp"

namespace musclebench {

/// A surface of nearly equilateral triangles on field = 0, with exactly `vertices` vertices, from a rough one: edges
/// are split, collapsed and flipped, vertices slide along the surface and are put back on it (Botsch and Kobbelt 2004,
/// A Remeshing Approach to Multiresolution Modeling). Topology is kept; `rough` must be closed, manifold and outward.
TriangleMesh remesh_isotropic(const TriangleMesh& rough, const Field& field, int vertices);

}  // namespace musclebench

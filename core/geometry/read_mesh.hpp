#pragma once

#include <filesystem>

#include "core/geometry/triangle_mesh.hpp"

namespace musclebench {

/// Reads a triangle surface in any format that assimp knows (PLY, OBJ, STL, OFF, ...), in metres. Vertex order and count are
/// those of the file; coordinates are rounded to 32-bit floats by assimp (at 0.5 m: 30 nm). Polygons are split into triangles.
/// Throws InputError that names the file for a missing, empty, truncated or unreadable file, a face index out of range, a
/// vertex that is not finite (with its index), or a file without triangles.
TriangleMesh read_mesh(const std::filesystem::path& path);

/// Writes binary little-endian PLY with double coordinates. Throws InputError when the file cannot be written.
void write_ply(const TriangleMesh& mesh, const std::filesystem::path& path);

}  // namespace musclebench

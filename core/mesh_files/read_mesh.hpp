#pragma once

#include <filesystem>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Reads a triangle surface, in metres. Vertex order and count are those of the file, unreferenced and equal vertices
/// included, and coordinates keep their digits, for PLY (text, binary of both byte orders), OBJ and OFF (text); STL has
/// no shared vertices by its format, so there each corner is a vertex. These four are parsed strictly; any other format
/// that assimp knows by its ending is read through assimp, with the meshes of the file placed and joined as its nodes
/// say, in 32-bit floats, and there the vertices are those that assimp makes. Triangles keep the order of the file;
/// larger polygons are split in place, points and lines are left out. Throws InputError that names the file for a
/// missing, empty, truncated or unreadable file, an unknown ending, a face index out of range, a vertex that is not
/// finite (with its index, from 0), or a file whose triangles have no area. A text format without promised counts (OBJ)
/// that is cut off at the end of a line can't be told from a whole one.
TriangleMesh read_mesh(const std::filesystem::path& path);

/// Writes binary little-endian PLY with double coordinates, as `write_atomically` does.
void write_ply(const TriangleMesh& mesh, const std::filesystem::path& path);

}  // namespace musclebench

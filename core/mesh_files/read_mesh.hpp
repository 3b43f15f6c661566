#pragma once

#include <filesystem>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Reads a triangle surface. The unit of the file is taken as metres.
///
/// - PLY (text, and binary of both byte orders), OBJ, OFF (text) and STL have strict parsers. Their coordinates keep
///   all digits. Vertices keep the order and count of the file, including unused and equal ones.
/// - STL does not share vertices. Each corner of a triangle becomes a vertex.
/// - The library assimp reads any other format that it knows by the file's ending. It places and joins the meshes of
///   the file, and stores coordinates as 32-bit floats.
///
/// Triangles keep the order of the file. Larger polygons are split in place. Points and lines are left out.
///
/// Throws InputError that names the file if it is missing, empty, truncated or unreadable; if its ending is unknown; if
/// a face index is out of range; if a vertex is not finite; or if no triangle has an area. An OBJ file that is cut off
/// at the end of a line cannot be detected, because the format has no counts.
///
/// Safe from several threads.
TriangleMesh read_mesh(const std::filesystem::path& path);

/// Writes the mesh as binary little-endian PLY with double coordinates. The file appears whole or not at all. Throws
/// InputError if it cannot be written.
void write_ply(const TriangleMesh& mesh, const std::filesystem::path& path);

}  // namespace musclebench

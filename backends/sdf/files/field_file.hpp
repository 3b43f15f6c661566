#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/grid/cubic_field.hpp"
#include "core/mesh_repair/repair_mesh.hpp"

namespace musclebench {

/// SHA-256 of a surface's vertices and triangles and of how its sign is found, in hexadecimal.
std::string surface_digest(const RepairedMesh& surface);

/// Writes a field in this machine's byte order, to a temporary name first, so that a half-written file is never found
/// under `path`. Creates the folder. Throws InputError (about the path) when that fails; nothing is left behind.
void save_field(const CubicField& field, const std::string& digest, const std::filesystem::path& path);

/// Reads what `save_field` wrote; nothing when there is no such file. Throws InputError (about the path) that says
/// what differs when the file is not a field, was written by another version or byte order, for another surface or
/// grid, or is damaged.
std::optional<CubicField> load_field(const std::filesystem::path& path, const std::string& digest,
                                     const GridShape& shape);

}  // namespace musclebench

#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "backends/sdf/build/octree_builder.hpp"
#include "backends/sdf/octree/octree_field.hpp"

namespace musclebench {

/// Writes an adaptive field in this machine's byte order, to a temporary name first. `digest` is that of the surface
/// (see `surface_digest`), `settings` are those it was built with. Throws InputError (about the path).
void save_octree(const OctreeField& field, const std::string& digest, const OctreeSettings& settings,
                 const std::filesystem::path& path);

/// Reads what `save_octree` wrote; nothing when there is no such file. Throws InputError (about the path) that says
/// what differs when the file is none, was written by another version or byte order, for another surface, error or
/// margin, or is damaged.
std::optional<OctreeField> load_octree(const std::filesystem::path& path, const std::string& digest,
                                       const OctreeSettings& settings);

}  // namespace musclebench

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/fibres/fibre_segments.hpp"
#include "core/mesh/triangle_mesh.hpp"
#include "core/scene/mesh_placement.hpp"

namespace musclebench {

/// The points of an attachment in a landmark file (the JSON beside the LHDL meshes): `selector` is `muscle/role`,
/// `muscle/role/part`, or either with `/1`, `/2` ... for the first, second ... of that name in the file. The file's
/// points are in metres; `placement` is that of the mesh whose frame they are in. Throws InputError where none or
/// several match, with the nearest or those that do.
std::vector<Vec3> read_landmark_outline(const std::filesystem::path& path, const std::string& selector,
                                        const MeshPlacement& placement = {});

/// The fibre polylines of `muscle` in a landmark file, as segments. Throws InputError with the nearest known muscle.
std::vector<FibreSegment> read_landmark_fibres(const std::filesystem::path& path, const std::string& muscle,
                                               const MeshPlacement& placement = {});

}  // namespace musclebench

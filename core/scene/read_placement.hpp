#pragma once

#include <string>
#include <vector>

#include "core/scene/mesh_placement.hpp"
#include "core/scene/toml_table.hpp"

namespace musclebench {

/// The keys of a [[bone]] or [[muscle]] that place its mesh.
inline const std::vector<std::string> placement_keys = {"unit", "scale", "rotate_deg", "translate_m"};

/// What `table` says; the identity without these keys. Throws InputError.
MeshPlacement read_placement(const TomlTable& table);

}  // namespace musclebench

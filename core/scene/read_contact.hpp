#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "core/scene/scene.hpp"
#include "core/scene/toml_table.hpp"

namespace musclebench {

/// The index of the muscle of that name. Throws InputError that names `location` and the nearest name.
std::size_t find_muscle(const Scene& scene, const std::string& name, const std::string& location);

/// The same of a bone.
std::size_t find_bone(const Scene& scene, const std::string& name, const std::string& location);

/// What `[contact]` says of the response. Throws InputError for an unknown key or response, and for a number of steps
/// that is not whole or out of range.
void read_response(const std::optional<TomlTable>& contact, Scene& scene);

/// What `[[bone]]`, or a `[[pair]]` of a muscle and a bone, says of contact. Throws InputError for an unknown response
/// and such a number of steps.
SceneBoneContact read_bone_contact(const TomlTable& table);

/// Which muscles touch each other: all by `[contact] muscle_contact`, or those of each `[[pair]]`; and what is said of
/// contact between each muscle and bone, by the bone or by a `[[pair]]`. Bones and muscles have been read. Throws
/// InputError for a pair that is none or stands twice, and for an open muscle that touches another.
void read_pairs(const TomlTable& root, const std::optional<TomlTable>& contact, Scene& scene);

}  // namespace musclebench

#pragma once

#include "core/scene/scene.hpp"
#include "core/scene/scene_request.hpp"
#include "core/scene/toml_table.hpp"

namespace musclebench {

/// `attachment = "first_contact"`, or the `[[attachment]]` tables and the nodes that they bind. Bones and muscles have
/// been read. Throws InputError for an unknown bone, muscle or key, and for an outline of fewer than three points.
void read_attachments(const SceneRequest& request, const TomlTable& root, Scene& scene);

}  // namespace musclebench

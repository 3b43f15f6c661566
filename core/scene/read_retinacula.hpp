#pragma once

#include "core/scene/scene.hpp"
#include "core/scene/toml_table.hpp"

namespace musclebench {

/// The `[[retinaculum]]` tables and the nodes that run through them. Bones and muscles have been read. Throws
/// InputError for an unknown bone, muscle or key, for a ring that nothing passes through, for one that the muscle is
/// wider than at rest, and for one so narrow that an edge could pass it without a node in it.
void read_retinacula(const TomlTable& root, Scene& scene);

}  // namespace musclebench

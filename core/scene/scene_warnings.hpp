#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.hpp"

namespace musclebench {

/// What is odd about the scene, one line each: meshes that seem to be in another unit, far away or in pieces, nodes
/// that begin inside a bone, bones with holes, attachments without nodes, fibres outside their muscle, motions of more
/// than a turn. Empty when all is well. What is odd about its effects: `check_scene`.
std::vector<SceneWarning> scene_warnings(const Scene& scene);

/// The sentence about an attachment without nodes: how far the nearest node is.
std::string describe_empty_attachment(const Scene& scene, const Attachment& attachment);

/// Why `between_attachments` gives no fibres: which attachment has how many nodes.
std::string describe_missing_fibres(const Scene& scene, std::size_t muscle);

}  // namespace musclebench

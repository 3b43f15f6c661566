#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Simple bodies made by code, each in its place, for scenes that show one effect alone (core/effects/NAME/scene.toml).
/// Metres, z up; what lies on something touches z = 0. Throws InputError for an unknown name.
TriangleMesh simple_shape(std::string_view name);

std::vector<std::string> simple_shape_names();

}  // namespace musclebench

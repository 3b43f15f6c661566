#pragma once

#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "core/scene/scene_request.hpp"

namespace musclebench {

/// How a command line changes the effects of a scene.
struct EffectOptions {
  std::vector<std::string> added;    ///< NAME or NAME:key=value,key=value
  std::vector<std::string> removed;  ///< NAME
};

void add_effect_options(CLI::App& command, EffectOptions& options);

/// Throws InputError where an option is not of its form.
std::vector<EffectOverride> effect_overrides(const EffectOptions& options);

}  // namespace musclebench

#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "bench/trials/effect_search.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// The file that keeps what a search for effects finds for `scene`: in $XDG_CACHE_HOME or ~/.cache, named by a hash of
/// the scene before the search, its meshes, and this program. `resolved_text`: the scene in full, with `[wanted]`.
/// Nothing where there is no such folder, or the program can't be read.
std::optional<std::filesystem::path> kept_effects_file(const Scene& scene, const std::string& resolved_text);

/// Adds to the scene what an earlier search found: `added` and `unmet`. Nothing, and the scene as it was, where there
/// is no such file or it can't be used.
std::optional<EffectChoice> add_kept_effects(const std::filesystem::path& file, Scene& scene);

/// `scene`: with what was found. Where nothing can be written, the next run searches again.
void keep_effects(const std::filesystem::path& file, const Scene& scene, const EffectChoice& found);

}  // namespace musclebench

#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "bench/trials/effect_search.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// The file that keeps what a search for effects finds for `scene`. It lies in $XDG_CACHE_HOME or ~/.cache. Its name is
/// a hash of the scene before the search, its meshes, what it keeps out, and this program. `resolved_text`: the scene
/// in full, with `[wanted]`. Nothing where there is no such folder, or the program can't be read.
std::optional<std::filesystem::path> kept_effects_file(const Scene& scene, const std::string& resolved_text);

/// Adds to the scene what an earlier search found, and returns that: `added`, `unmet` and
/// `judged_all_frames`, nothing else. Where there is
/// no such file, or it can't be used, the scene stays as it was and nothing is returned.
std::optional<EffectChoice> add_kept_effects(const std::filesystem::path& file, Scene& scene);

/// Writes what was found and added to `scene`, for add_kept_effects. Where that fails the next run searches again.
void keep_effects(const std::filesystem::path& file, const Scene& scene, const EffectChoice& found);

}  // namespace musclebench

#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "core/scene/scene_request.hpp"

namespace musclebench {

/// How the user names a scene.
struct SceneChoice {
  std::string scene;   ///< the name of an embedded scene or the path of a .toml file
  std::string preset;  ///< empty: the scene's own
  std::string data;    ///< folder of the anatomical data; empty: $MUSCLEBENCH_DATA
  std::map<std::string, ParameterValue> loop_overrides;
  std::vector<EffectOverride> effect_overrides = {};
  std::map<std::string, ParameterValue> motion_overrides = {};
  std::map<std::string, ParameterValue> mesh_overrides = {};
  std::map<std::string, ParameterValue> wanted_overrides = {};
  std::optional<FibreRequest> fibres = {};                     ///< over the scene's
  bool notes_obstacles = false;                                ///< see SceneRequest
  bool auto_effects = false;                                   ///< as if the scene said `effects = "auto"`
  std::function<void(int done, int total)> check_report = {};  ///< of the check that such a scene asks for
};

/// Reads the scene. One that asks for effects and says what it wants still lacks those that a search would add.
/// Throws InputError; an unknown name is answered with the list of embedded scenes.
Scene load_scene(const SceneChoice& choice);

/// `scene`, which was loaded from `choice`, as a file that names loop, effects and pairs in full (resolved_scene_text).
std::string resolved_scene(const SceneChoice& choice, const Scene& scene);

/// The folder of the anatomical data: `option`, else $MUSCLEBENCH_DATA, else nothing.
std::optional<std::filesystem::path> data_folder(const std::string& option);

}  // namespace musclebench

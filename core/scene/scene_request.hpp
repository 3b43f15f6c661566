#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/input_error.hpp"
#include "core/base/parameters.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A change to one effect of a scene, from the command line.
struct EffectOverride {
  std::string location;                               ///< for messages: the option as the user wrote it
  std::string name;                                   ///< of the effect
  bool is_removed = false;                            ///< false: the effect is added, or its values are changed
  std::map<std::string, ParameterValue> values = {};  ///< new values; all others stay
};

/// A request from the command line to follow fibres.
struct FibreRequest {
  int count = 0;            ///< number of fibres for each muscle; 0: none
  std::string option = {};  ///< for messages: the option that asks for them
  bool is_required = true;  ///< false: the scene may run without fibres (`Scene::fibres_refused`)
};

/// The input of `read_scene`: the text of a scene, and how to find the files that it names.
struct SceneRequest {
  std::string name;                                  ///< name of the scene, for results
  std::string file;                                  ///< file of the scene, for messages
  std::string text;                                  ///< the scene in TOML
  std::filesystem::path folder;                      ///< base of relative mesh paths
  std::string preset_override;                       ///< preset to use; empty: the one that the scene names
  std::optional<std::filesystem::path> data_folder;  ///< value of `${data}` in paths
  /// Returns the text of a preset. Throws InputError for an unknown one. Needed for scenes with a preset.
  std::function<std::string(const std::string& preset)> preset_text;
  /// Returns a mesh that is made by code. Throws InputError for an unknown name. Needed for scenes with such meshes.
  std::function<TriangleMesh(const std::string& name)> synthetic_mesh;
  std::map<std::string, ParameterValue> loop_overrides;         ///< values for `[loop]`, from the command line
  std::vector<EffectOverride> effect_overrides;                 ///< changes to effects, from the command line
  std::map<std::string, ParameterValue> motion_overrides = {};  ///< values for the motions of all moving bones
  std::map<std::string, ParameterValue> mesh_overrides = {};    ///< values for `[meshes]`
  std::map<std::string, ParameterValue> wanted_overrides = {};  ///< values for `[wanted]`
  std::optional<FibreRequest> fibres = {};                      ///< replaces `[measure] fibres`
  bool auto_effects = false;                                    ///< reads the scene as with `effects = "auto"`
  /// Continue if something prevents a run but not a look at the scene. `Scene::obstacles` then names it.
  bool notes_obstacles = false;
};

/// A reference in a scene to a file, `file` or `file#selector`, split in two.
struct SceneReference {
  std::filesystem::path path;
  std::string selector;  ///< the part after `#`; empty without `#`
};

/// Resolves a reference relative to the scene's folder, and `${data}` to the data folder. Throws InputError that names
/// `location` if the data folder is needed but unknown.
SceneReference resolve_reference(const SceneRequest& request, const std::string& text, const std::string& location);

/// Calls `read` and returns its result. If it throws InputError about another file, `location` is put first: the line
/// of the scene that names that file.
template <typename Read>
auto read_at(const std::string& location, const Read& read) {
  try {
    return read();
  } catch (const InputError& error) {
    const std::string message = error.what();
    throw message.starts_with(location) ? error : InputError(location, message);
  }
}

}  // namespace musclebench

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

/// What a user says of one effect besides scene and preset.
struct EffectOverride {
  std::string location;  ///< for messages: the option as it was written
  std::string name;
  bool is_removed = false;                            ///< else it is added, or some of its values are changed
  std::map<std::string, ParameterValue> values = {};  ///< what is not given stays as the scene has it
};

/// Fibres that a command line asks for.
struct FibreRequest {
  int count = 0;            ///< of each muscle; 0: none
  std::string option = {};  ///< that asks, for messages
  bool is_required = true;  ///< false: the scene may go without (`Scene::fibres_refused`)
};

/// Where a scene comes from and where its references lead.
struct SceneRequest {
  std::string name;                                  ///< of the scene, for results
  std::string file;                                  ///< of the scene, for messages
  std::string text;                                  ///< TOML
  std::filesystem::path folder;                      ///< relative mesh paths start here
  std::string preset_override;                       ///< preset to use instead of the scene's; empty: the scene's own
  std::optional<std::filesystem::path> data_folder;  ///< what `${data}` stands for
  std::function<std::string(const std::string& preset)> preset_text;    ///< throws InputError for an unknown preset
  std::function<TriangleMesh(const std::string& name)> synthetic_mesh;  ///< throws InputError for an unknown name
  std::map<std::string, ParameterValue> loop_overrides;                 ///< such as `frames`, from the command line
  std::vector<EffectOverride> effect_overrides;                         ///< the same of effects
  std::map<std::string, ParameterValue> motion_overrides = {};          ///< of all bones that move
  std::optional<FibreRequest> fibres = {};                              ///< over `[measure] fibres`
  bool auto_effects = false;                                            ///< as if the scene said `effects = "auto"`
  /// Goes on past what only a run minds, which is noted in `Scene::obstacles`: for a look at the scene.
  bool notes_obstacles = false;
};

/// A path that a scene names, or its `file#selector` cut in two.
struct SceneReference {
  std::filesystem::path path;
  std::string selector;  ///< empty without `#`
};

/// Relative to the scene's folder, `${data}` to the data folder. Throws InputError with `location` where that folder is
/// needed and not known.
SceneReference resolve_reference(const SceneRequest& request, const std::string& text, const std::string& location);

/// What `read` returns; its complaints of another file begin with the line of the scene that names that file.
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

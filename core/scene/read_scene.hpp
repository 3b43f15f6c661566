#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "core/scene/effect_override.hpp"
#include "core/scene/fibre_request.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

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

/// What may be changed of the motion of all bones that move.
std::vector<ParameterSpec> motion_parameters();

/// Reads a scene with all its files. Throws InputError that names file, line and key.
Scene read_scene(const SceneRequest& request);

}  // namespace musclebench

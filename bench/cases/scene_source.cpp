#include "bench/cases/scene_source.hpp"

#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/base/input_file.hpp"
#include "core/scene/check/auto_effects.hpp"
#include "core/scene/read_scene.hpp"
#include "datasets/embedded/embedded_files.hpp"
#include "datasets/simple_shapes.hpp"
#include "datasets/synthetic_hip.hpp"

namespace musclebench {

namespace {

const EmbeddedFile* find_file(std::span<const EmbeddedFile> files, std::string_view name) {
  const auto found = std::find_if(files.begin(), files.end(), [&](const EmbeddedFile& f) { return f.name == name; });
  return found == files.end() ? nullptr : &*found;
}

std::vector<std::string> names_of(std::span<const EmbeddedFile> files) {
  std::vector<std::string> names;
  for (const EmbeddedFile& file : files) {
    names.emplace_back(file.name);
  }
  return names;
}

/// Scenes are written by hand; what is larger is something else.
constexpr std::uintmax_t most_bytes_of_a_scene = 4 << 20;

[[noreturn]] void refuse_name(const std::string& name) {
  const std::string file = name + ".toml";
  if (std::filesystem::exists(file)) {
    throw InputError(name, fmt::format("is neither an embedded scene nor a .toml file; did you mean '{}'?", file));
  }
  throw InputError(name, fmt::format("is neither an embedded scene nor a .toml file; did you mean '{}'? "
                                     "`musclebench list` shows all scenes",
                                     nearest_word(name, names_of(embedded_scenes()))));
}

std::string preset_text(const std::string& name) {
  const EmbeddedFile* file = find_file(embedded_presets(), name);
  if (file == nullptr) {
    throw InputError(fmt::format("'{}'", name),
                     fmt::format("is no preset; did you mean '{}'?", nearest_word(name, names_of(embedded_presets()))));
  }
  return std::string(file->text);
}

TriangleMesh synthetic_mesh(const std::string& name) {
  std::vector<std::string> known = simple_shape_names();
  if (std::ranges::find(known, name) != known.end()) {
    return simple_shape(name);
  }
  const std::vector<std::string> of_hip = synthetic_hip_names();
  known.insert(known.end(), of_hip.begin(), of_hip.end());
  if (std::ranges::find(of_hip, name) == of_hip.end()) {
    throw InputError("synthetic:" + name, fmt::format("is unknown; did you mean '{}'?", nearest_word(name, known)));
  }
  return synthetic_hip_mesh(name);
}

}  // namespace

std::optional<std::filesystem::path> data_folder(const std::string& option) {
  if (!option.empty()) {
    if (!std::filesystem::is_directory(option)) {
      throw InputError("--data " + option, "is not a folder; give the one that holds lhdl.json and meshes/");
    }
    return option;
  }
  const char* variable = std::getenv("MUSCLEBENCH_DATA");
  if (variable == nullptr || *variable == '\0') {
    return std::nullopt;
  }
  if (!std::filesystem::is_directory(variable)) {
    throw InputError(fmt::format("MUSCLEBENCH_DATA={}", variable),
                     "is not a folder; set it to the one that holds lhdl.json and meshes/");
  }
  return variable;
}

namespace {

/// Of the meshes of an embedded scene. Throws InputError where they are not there.
std::filesystem::path mesh_folder(const EmbeddedFile& file) {
  if (file.folder.empty()) return {};
  const char* variable = std::getenv("MUSCLEBENCH_DATASETS");
  const bool is_set = variable != nullptr && *variable != '\0';
  const std::filesystem::path datasets = is_set ? variable : std::string(datasets_of_build());
  if (!std::filesystem::is_directory(datasets / file.folder)) {
    throw InputError(std::string(file.name),
                     fmt::format("needs {}, which is not there; set MUSCLEBENCH_DATASETS to the folder datasets of the "
                                 "sources",
                                 (datasets / file.folder).string()));
  }
  return datasets / file.folder;
}

SceneRequest request_of(const SceneChoice& choice) {
  SceneRequest request;
  request.preset_override = choice.preset;
  request.preset_text = preset_text;
  request.synthetic_mesh = synthetic_mesh;
  request.data_folder = data_folder(choice.data);
  request.loop_overrides = choice.loop_overrides;
  request.effect_overrides = choice.effect_overrides;
  request.motion_overrides = choice.motion_overrides;
  request.mesh_overrides = choice.mesh_overrides;
  request.wanted_overrides = choice.wanted_overrides;
  request.fibres = choice.fibres;
  request.notes_obstacles = choice.notes_obstacles;
  request.auto_effects = choice.auto_effects;
  if (const EmbeddedFile* file = find_file(embedded_scenes(), choice.scene)) {
    request.name = choice.scene;
    request.file = choice.scene;
    request.text = file->text;
    request.folder = mesh_folder(*file);
  } else if (choice.scene.ends_with(".toml")) {
    request.name = std::filesystem::path(choice.scene).stem().string();
    request.file = choice.scene;
    request.folder = std::filesystem::path(choice.scene).parent_path();
    request.text = InputFile(choice.scene).text(most_bytes_of_a_scene);
  } else {
    refuse_name(choice.scene);
  }
  return request;
}

}  // namespace

Scene load_scene(const SceneChoice& choice) {
  const SceneRequest request = request_of(choice);
  Scene scene = read_scene(request);
  if (scene.auto_effects.wanted && !scene.wanted.is_given) {
    add_advised_effects(scene, choice.check_report);
    scene.auto_effects.resolved_text = resolved_scene_text(request, scene);
  }
  return scene;
}

std::string resolved_scene(const SceneChoice& choice, const Scene& scene) {
  return resolved_scene_text(request_of(choice), scene);
}

}  // namespace musclebench

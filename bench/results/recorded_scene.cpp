#include "bench/results/recorded_scene.hpp"

#include <fmt/format.h>

#include "bench/cases/scene_source.hpp"
#include "bench/results/manifest.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

Scene scene_of(const RecordingHeader& header, const RecordedScene& options) {
  SceneChoice choice;
  choice.scene = options.scene.empty() ? header.scene_source : options.scene;
  choice.preset = header.preset;
  choice.data = options.data;
  choice.loop_overrides = header.loop_overrides;
  choice.motion_overrides = header.motion_overrides;
  choice.mesh_overrides = header.mesh_overrides;
  return load_scene(choice);
}

void require_same_scene(const Scene& scene, const RecordingHeader& header, const std::string& recording) {
  const auto nodes = static_cast<int>(scene.muscle_mesh.vertices.size());
  const auto muscles = static_cast<int>(scene.muscles.size());
  const auto bones = static_cast<int>(scene.bones.size());
  if (nodes != header.nodes || muscles != header.muscles || bones != header.bones) {
    throw InputError(
        recording,
        fmt::format("is of '{}' (muscles {}, nodes {}, bones {}), and '{}' has {}, {} and {}; name the right one with "
                    "--scene, or record it again",
                    header.scene, header.muscles, header.nodes, header.bones, scene.name, muscles, nodes, bones));
  }
  const std::string hash = scene_hash(scene);
  if (hash != header.scene_sha256) {
    throw InputError(recording, fmt::format("is of another scene: '{}' with hash {}, and '{}' as it is now has {}; "
                                            "name the right one with --scene, or record it again",
                                            header.scene, header.scene_sha256, scene.name, hash));
  }
}

}  // namespace

Scene load_recorded_scene(const RecordingHeader& header, const RecordedScene& options) {
  Scene scene = scene_of(header, options);
  require_same_scene(scene, header, options.recording);
  return scene;
}

}  // namespace musclebench

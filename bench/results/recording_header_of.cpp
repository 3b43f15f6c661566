#include "bench/results/recording_header_of.hpp"

#include <filesystem>

#include "bench/results/build_info.hpp"
#include "bench/results/manifest.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

namespace {

namespace fs = std::filesystem;

/// An embedded scene by its name, a file by its absolute path.
std::string source_of(const SceneChoice& choice) {
  return choice.scene.ends_with(".toml") ? fs::absolute(choice.scene).lexically_normal().string() : choice.scene;
}

}  // namespace

RecordingHeader recording_header(const Case& resolved, const SceneChoice& choice, const FrameRange& frames,
                                 std::span<const int> free_nodes) {
  const Scene& scene = resolved.scene;
  RecordingHeader header;
  header.scene = scene.name;
  header.scene_source = source_of(choice);
  header.preset = choice.preset;
  header.loop_overrides = choice.loop_overrides;
  header.motion_overrides = choice.motion_overrides;
  header.mesh_overrides = choice.mesh_overrides;
  header.scene_sha256 = scene_hash(scene);
  header.backend = resolved.backend.name;
  header.build = build_info().git;
  header.nodes = static_cast<int>(scene.muscle_mesh.vertices.size());
  header.muscles = static_cast<int>(scene.muscles.size());
  header.muscle_contact = !scene.muscle_pairs.empty();
  header.bones = static_cast<int>(scene.bones.size());
  header.substeps = scene.loop.substeps;
  header.iterations = scene.loop.iterations;
  header.rounding_m = rounding_step_m(scene_diagonal_m(scene));
  for (int frame = frames.first; frame <= frames.last; ++frame) {
    header.angles_deg.push_back(scene.angle_rad(frame) * degrees_per_radian);
  }
  header.free_nodes.assign(free_nodes.begin(), free_nodes.end());
  return header;
}

}  // namespace musclebench

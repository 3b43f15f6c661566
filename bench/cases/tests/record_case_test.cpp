#include "bench/cases/record_case.hpp"

#include <filesystem>
#include <memory>

#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "core/base/temporary_folder.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/mesh/shapes.hpp"
#include "core/recording/recording_reader.hpp"
#include "core/referee/tests/test_bones.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {
namespace {

namespace fs = std::filesystem;

constexpr int frame_count = 5;

/// A ball that falls beside a bone that turns.
Scene falling_ball(double acceleration_m_per_s2) {
  Scene scene;
  scene.name = "falling ball";
  scene.bones.push_back(bone_of(make_sphere(0.05, 2)));
  scene.bone_meshes.push_back({"bone", "", scene.bones[0].surface.mesh});
  BoneRotation motion;
  motion.axis = Vec3::UnitZ();
  motion.times = {0, 1};
  motion.angles_rad = {0, 1};
  scene.motions.push_back({{motion}});
  scene.add_muscle("muscle", moved(make_sphere(0.02, 2), Vec3(0.2, 0, 0)));
  scene.loop.frames = frame_count;
  scene.loop.substeps = 2;
  scene.loop.iterations = 3;
  scene.effects.push_back(
      {"gravity", Parameters(find_effect("gravity")->parameters, {{"z_m_per_s2", -acceleration_m_per_s2}}, "test")});
  return scene;
}

/// A recording in the folder of tests, and the simulation that it is made of.
struct Recorded {
  Scene scene;
  std::unique_ptr<CollisionBackend> backend;
  PreparedSimulation prepared;
  RecordingHeader header;
  TemporaryFolder folder;
  fs::path file = folder / "recording";
  std::string lost;
  int frames_reported = 0;

  explicit Recorded(double acceleration_m_per_s2) : scene(falling_ball(acceleration_m_per_s2)) {
    const BackendEntry& entry = find_backend("null");
    backend = entry.make(Parameters(entry.parameters, {}, "test"));
    backend->build(scene.bones, scene.muscle_mesh, 1);
    prepared = prepare_simulation(scene, *backend, {entry.default_response}, 1);
    header.scene = scene.name;
    header.scene_sha256 = std::string(64, '0');
    header.backend = entry.name;
    header.nodes = static_cast<int>(scene.muscle_mesh.vertices.size());
    header.bones = 1;
    header.substeps = scene.loop.substeps;
    header.iterations = scene.loop.iterations;
    header.rounding_m = rounding_step_m(scene_diagonal_m(scene));
    header.angles_deg.assign(frame_count, 0);
    const auto free_nodes = prepared.simulation->free_nodes();
    header.free_nodes.assign(free_nodes.begin(), free_nodes.end());
  }

  void write(bool finish) {
    RecordingWriter writer(file, header);
    lost = record_frames(*prepared.simulation, scene, writer,
                         [this](int frames_done) { EXPECT_EQ(frames_done, ++frames_reported); });
    if (finish) writer.finish();
  }
};

TEST(RecordFrames, EveryStepOfEveryFrameReadsBack) {
  Recorded recorded(9.81);
  recorded.write(true);
  EXPECT_EQ(recorded.lost, "");
  EXPECT_EQ(recorded.frames_reported, frame_count);
  RecordingReader reader(recorded.file);
  RecordedFrame frame;
  const double start_m = recorded.scene.muscle_mesh.vertices[0].z();
  double last_m = start_m;
  for (int read = 1; read <= frame_count; ++read) {
    reader.read(frame);
    ASSERT_EQ(frame.steps.size(), 6U);
    EXPECT_LT(frame.steps.back().positions[0].z(), last_m) << "frame " << read;
    last_m = frame.steps.back().positions[0].z();
  }
  // Nothing but gravity acts, so that the last step is where the simulation ended.
  EXPECT_NEAR(last_m, recorded.prepared.simulation->positions()[0].z(), recorded.header.rounding_m);
  EXPECT_FALSE(frame.steps.back().bone_poses[0].rotation.isApprox(frame.steps.front().previous_bone_poses[0].rotation));
  fs::remove(recorded.file);
}

TEST(RecordFrames, ARunThatBlowsUpSaysWhereAndLeavesNothing) {
  Recorded recorded(1e6);
  recorded.write(false);
  EXPECT_EQ(recorded.lost.rfind("frame ", 0), 0U) << recorded.lost;
  EXPECT_LT(recorded.frames_reported, frame_count);
  EXPECT_FALSE(fs::exists(recorded.file));
}

}  // namespace
}  // namespace musclebench

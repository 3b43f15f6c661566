#include "bench/results/manifest.hpp"

#include <functional>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "bench/results/tests/small_run.hpp"

namespace musclebench {
namespace {

Scene two_muscles() {
  Scene scene = plain_scene();
  scene.add_muscle("other", make_sphere(0.02, 1));
  scene.muscle_pairs.push_back({.muscles = {0, 1}});
  scene.bone_contacts.resize(2);
  Attachment attachment;
  attachment.name = "origin";
  attachment.nodes = {1, 2};
  scene.attachments.push_back(attachment);
  return scene;
}

/// Whatever a run's answers depend on gives its recording another hash.
TEST(SceneHash, IsThatOfEverythingTheSceneSays) {
  const std::map<std::string, std::function<void(Scene&)>> changes = {
      {"response steps", [](Scene& s) { s.response_steps = 7; }},
      {"steps of a bone", [](Scene& s) { s.bone_contacts[1].response_steps = 7; }},
      {"steps of the other muscle's bone", [](Scene& s) { s.bone_contacts[0].response_steps = 7; }},
      {"steps of a pair", [](Scene& s) { s.muscle_pairs[0].response_steps = 7; }},
      {"no pair", [](Scene& s) { s.muscle_pairs.clear(); }},
      {"frames", [](Scene& s) { s.loop.frames = 3; }},
      {"substeps", [](Scene& s) { s.loop.substeps = 2; }},
      {"time step", [](Scene& s) { s.loop.time_step_s *= 2; }},
      {"motion",
       [](Scene& s) {
         s.motions[0].rotations.push_back({.times = {0, 1}, .angles_rad = {0, 1}});
       }},
      {"bone's mesh", [](Scene& s) { s.bone_meshes[0].sha256 = "another"; }},
      {"split muscles", [](Scene& s) { s.mesh_splits.split_muscles = 1; }},
      {"smooth bones", [](Scene& s) { s.mesh_splits.smooth_bones = 1; }},
      {"attached nodes", [](Scene& s) { s.attachments[0].nodes.pop_back(); }},
      {"fibres",
       [](Scene& s) {
         s.muscles[1].fibres.push_back({Vec3(0, 0, 0), Vec3(0, 0, 1)});
       }},
  };
  const std::string as_it_is = scene_hash(two_muscles());
  EXPECT_EQ(scene_hash(two_muscles()), as_it_is);
  std::map<std::string, std::string> by_hash = {{as_it_is, "as it is"}};
  for (const auto& [what, change] : changes) {
    Scene scene = two_muscles();
    change(scene);
    const auto [first, is_new] = by_hash.emplace(scene_hash(scene), what);
    EXPECT_TRUE(is_new) << what << " has the hash of: " << first->second;
  }
}

}  // namespace
}  // namespace musclebench

// Contacts between real muscles, as they are shipped; where the anatomical data is.
#include <algorithm>

#include <gtest/gtest.h>

#include "bench/cases/collider_backends.hpp"
#include "bench/cases/scene_source.hpp"
#include "core/mesh/tests/lhdl_data.hpp"
#include "core/mesh_files/read_mesh.hpp"
#include "core/mesh_repair/weld_mesh.hpp"
#include "core/referee/muscle_referee.hpp"

namespace musclebench {
namespace {

std::vector<MuscleContact> contacts_of(const std::string& backend, const TouchingMuscles& muscles) {
  const BackendEntry& entry = find_backend(backend);
  const auto detector = entry.make_muscle_detector(Parameters(entry.parameters, {}, backend), muscles, 2);
  std::vector<MuscleContact> found;
  detector->detect(muscles.mesh.vertices, found);
  return found;
}

double deepest_m(const std::vector<MuscleContact>& contacts) {
  double deepest = 0;
  for (const MuscleContact& contact : contacts) deepest = std::max(deepest, contact.depth_m);
  return deepest;
}

void expect_same(const std::vector<MuscleContact>& found, const std::vector<MuscleContact>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].node, expected[i].node);
    ASSERT_EQ(found[i].muscle, expected[i].muscle);
    ASSERT_EQ(found[i].triangle, expected[i].triangle);
    ASSERT_EQ(found[i].depth_m, expected[i].depth_m);
  }
}

TEST(LhdlMuscleContact, FourMusclesAtOnceAreFoundAsByBruteForce) {
  if (!lhdl_folder()) GTEST_SKIP() << "without the anatomical data";
  const Scene scene = load_scene({"lhdl/hip", "", lhdl_folder()->string(), {}});
  TouchingMuscles muscles{scene.muscle_mesh, scene.bodies(), {}};
  for (const SceneMusclePair& pair : scene.muscle_pairs) muscles.pairs.push_back(pair.muscles);
  ASSERT_EQ(muscles.pairs.size(), 6U);
  expect_same(contacts_of("bvh", muscles), contacts_of("brute_force", muscles));
}

/// The two overlap by 4.2 mm as shipped.
TEST(LhdlMuscleContact, IliacusAndPsoasOverlapAsDeepAsOthersMeasured) {
  if (!lhdl_folder()) GTEST_SKIP() << "without the anatomical data";
  Scene scene;
  for (const char* name : {"iliacus_r", "psoas_r"}) {
    const TriangleMesh mesh = read_mesh(*lhdl_folder() / "meshes" / (std::string(name) + ".ply"));
    scene.add_muscle(name, weld_mesh(mesh, name).mesh);
  }
  const TouchingMuscles muscles{scene.muscle_mesh, scene.bodies(), {{0, 1}}};
  const std::vector<MuscleContact> found = contacts_of("bvh", muscles);
  EXPECT_NEAR(deepest_m(found), 4.2e-3, 0.1e-3);
  MuscleReferee referee(scene.muscle_mesh, {scene.bodies(), {{1}, {0}}});
  std::vector<Contact> truth;
  referee.judge(scene.muscle_mesh.vertices, truth);
  ASSERT_EQ(found.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    ASSERT_EQ(found[i].node, truth[i].node);
    ASSERT_NEAR(found[i].depth_m, truth[i].depth_m, 1e-12);
  }
}

}  // namespace
}  // namespace musclebench

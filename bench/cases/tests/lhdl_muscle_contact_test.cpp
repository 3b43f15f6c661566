// Contacts between real muscles, as they are shipped; where the anatomical data is.
#include <algorithm>
#include <map>
#include <utility>

#include <gtest/gtest.h>

#include "bench/cases/collider_backends.hpp"
#include "bench/cases/scene_source.hpp"
#include "core/mesh/tests/lhdl_data.hpp"
#include "core/mesh_files/read_mesh.hpp"
#include "core/mesh_repair/repair_mesh.hpp"
#include "core/mesh_repair/weld_mesh.hpp"
#include "core/referee/muscle_referee.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {
namespace {

TriangleMesh inflated(TriangleMesh mesh, double by_m) {
  std::vector<Vec3> normals(mesh.vertices.size(), Vec3::Zero());
  for (const Triangle& t : mesh.triangles) {
    const Vec3& corner = mesh.vertices[t[0]];
    const Vec3 area_normal = (mesh.vertices[t[1]] - corner).cross(mesh.vertices[t[2]] - corner);
    for (const int vertex : t) normals[vertex] += area_normal;
  }
  for (std::size_t i = 0; i < normals.size(); ++i) mesh.vertices[i] += by_m * normals[i].normalized();
  return mesh;
}

std::vector<MuscleContact> contacts_of(const std::string& backend, const TouchingMuscles& muscles,
                                       const TriangleMesh& now) {
  const BackendEntry& entry = find_backend(backend);
  const auto detector = entry.make_muscle_detector(Parameters(entry.parameters, {}, backend), muscles, 2);
  std::vector<MuscleContact> found;
  detector->detect(now.vertices, found);
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

/// Depths by node and the muscle that it is in.
using Depths = std::map<std::pair<int, int>, double>;

Depths depths_of(const std::vector<MuscleContact>& contacts) {
  Depths depths_m;
  for (const MuscleContact& contact : contacts) depths_m[{contact.node, contact.muscle}] = contact.depth_m;
  return depths_m;
}

bool with_fcl() {
  const auto& registry = backend_registry();
  return std::ranges::find(registry, "fcl", &BackendEntry::name) != registry.end();
}

/// FCL meets triangles that cut each other, and says of their corners which are inside. So it finds nothing that brute
/// force does not find, measures no depth below the true one (to the closest of the triangles that were met), and has
/// at least the inner corners of each triangle that is inside only in part; nodes deeper inside hang on no such
/// triangle.
void expect_what_hangs_on_cut_triangles(const Depths& found, const Depths& truth, const TriangleMesh& mesh,
                                        int muscles) {
  for (const auto& [contact, depth_m] : found) {
    ASSERT_TRUE(truth.contains(contact)) << "node " << contact.first << " is not in muscle " << contact.second;
    EXPECT_GE(depth_m, truth.at(contact) - 1e-15);
  }
  for (const Triangle& triangle : mesh.triangles) {
    for (int muscle = 0; muscle < muscles; ++muscle) {
      const auto is_inside = [&](int node) { return truth.contains({node, muscle}); };
      if (std::ranges::all_of(triangle, is_inside)) continue;
      for (const int node : triangle) {
        EXPECT_TRUE(!is_inside(node) || found.contains({node, muscle})) << "node " << node << ", muscle " << muscle;
      }
    }
  }
}

TEST(LhdlMuscleContact, FourMusclesAtOnceAreFoundAsByBruteForce) {
  if (!lhdl_folder()) GTEST_SKIP() << "without the anatomical data";
  const Scene scene = load_scene({"lhdl/hip", "", lhdl_folder()->string(), {}});
  TouchingMuscles muscles{scene.muscle_mesh, scene.bodies(), {}};
  for (const SceneMusclePair& pair : scene.muscle_pairs) muscles.pairs.push_back(pair.muscles);
  ASSERT_EQ(muscles.pairs.size(), 6U);
  const TriangleMesh now = inflated(scene.muscle_mesh, 1e-3);
  const std::vector<MuscleContact> truth = contacts_of("brute_force", muscles, now);
  EXPECT_GT(truth.size(), 100U);
  expect_same(contacts_of("bvh", muscles, now), truth);
  if (with_fcl()) {
    const Depths found = depths_of(contacts_of("fcl", muscles, now));
    EXPECT_GT(found.size(), 100U);
    expect_what_hangs_on_cut_triangles(found, depths_of(truth), now, static_cast<int>(scene.muscles.size()));
  }
  // At rest hardly any overlap. The Referee says which: brute force would take as long again.
  const std::vector<MuscleContact> at_rest = contacts_of("bvh", muscles, scene.muscle_mesh);
  EXPECT_LE(at_rest.size(), 100U);
  JudgedMuscles judged{scene.bodies(), std::vector<std::vector<int>>(scene.muscles.size())};
  for (const MusclePair& pair : muscles.pairs) {
    judged.beside[pair.first].push_back(pair.second);
    judged.beside[pair.second].push_back(pair.first);
  }
  std::vector<Contact> found_at_rest;
  MuscleReferee(scene.muscle_mesh, judged).judge(scene.muscle_mesh.vertices, found_at_rest);
  ASSERT_EQ(at_rest.size(), found_at_rest.size());
  for (std::size_t i = 0; i < at_rest.size(); ++i) ASSERT_EQ(at_rest[i].node, found_at_rest[i].node);
}

TEST(LhdlMuscleContact, GluteusMaximusLiesOverMediusAsCloseAsOthersMeasured) {
  if (!lhdl_folder()) GTEST_SKIP() << "without the anatomical data";
  const auto surface_of = [](const std::string& name) {
    return repair_mesh(read_mesh(*lhdl_folder() / "meshes" / (name + "_r.ply")), name);
  };
  const RepairedMesh maximus = surface_of("gluteus_maximus");
  const RepairedMesh medius = surface_of("gluteus_medius");
  double gap_m = 1;
  for (const auto& [nodes, surface] : {std::pair(&maximus, &medius), std::pair(&medius, &maximus)}) {
    const SignedSurface distance(*surface);
    for (const Vec3& node : nodes->mesh.vertices) gap_m = std::min(gap_m, *distance.distance(node));
  }
  EXPECT_NEAR(gap_m, 0.06e-3, 0.01e-3);
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
  const std::vector<MuscleContact> found = contacts_of("bvh", muscles, scene.muscle_mesh);
  EXPECT_NEAR(deepest_m(found), 4.2e-3, 0.1e-3);
  expect_same(found, contacts_of("brute_force", muscles, scene.muscle_mesh));
  if (with_fcl()) {
    const Depths cut = depths_of(contacts_of("fcl", muscles, scene.muscle_mesh));
    EXPECT_GT(cut.size(), 50U);
    expect_what_hangs_on_cut_triangles(cut, depths_of(found), scene.muscle_mesh, 2);
  }
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

// Scenes of several muscles: how they are read, and that muscles which do not touch each other move as if alone.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "bench/cases/case.hpp"
#include "bench/cases/collider_backends.hpp"
#include "core/base/input_error.hpp"
#include "core/mesh/shapes.hpp"
#include "core/scene/prepare_simulation.hpp"
#include "core/scene/read_scene.hpp"
#include "core/scene/scene_warnings.hpp"
#include "core/scene/tests/scene_errors.hpp"

namespace musclebench {
namespace {

constexpr const char* bones = R"(
[loop]
frames = 6
substeps = 4
density_kg_per_m3 = 1000.0
bone_motion = "interpolated"
[effects.attachment]
[effects.edge_length]
compliance_m_per_n = 0.01
[effects.volume]
[effects.bending]
[[bone]]
name = "plate"
mesh = "synthetic:plate"
[bone.motion]
axis = [0, 1, 0]
centre_m = [0, 0, 0]
from_deg = 0
to_deg = 25
course = "there"
[[bone]]
name = "lid"
mesh = "synthetic:lid"
)";

constexpr const char* bar = R"(
name = "bar"
mesh = "synthetic:bar"
fibres = "between_attachments"
)";
constexpr const char* ball = R"(
name = "ball"
mesh = "synthetic:ball"
)";

std::string attachment(const std::string& muscle, double x_m, const std::string& bone = "plate",
                       const std::string& z_m = "0.005") {
  const std::string left = std::to_string(x_m - 0.01);
  const std::string right = std::to_string(x_m + 0.01);
  return "\n[[attachment]]\nname = \"of_" + muscle + "\"\nbone = \"" + bone + "\"\nmuscle = \"" + muscle +
         "\"\noutline_m = [[" + left + ", -0.01, " + z_m + "], [" + right + ", -0.01, " + z_m + "], [" + right +
         ", 0.01, " + z_m + "], [" + left + ", 0.01, " + z_m + "]]\ndistance_m = 0.004\n";
}

std::string attachments_of_bar() { return attachment("bar", -0.05) + attachment("bar", -0.05, "lid", "0.0416"); }

const std::string all_touch = "[contact]\nmuscle_contact = true\n";

std::string pair(const std::string& one, const std::string& other, const std::string& more = "") {
  return "\n[[pair]]\nmuscles = [\"" + one + "\", \"" + other + "\"]\n" + more + "\n";
}

TriangleMesh shifted(TriangleMesh mesh, const Vec3& by_m) {
  for (Vec3& vertex : mesh.vertices) {
    vertex += by_m;
  }
  return mesh;
}

TriangleMesh mesh_of(const std::string& name) {
  if (name == "lid") return shifted(make_box(Vec3(0.02, 0.02, 0.005), 4), Vec3(-0.05, 0, 0.0466));
  if (name == "plate") return make_box(Vec3(0.1, 0.02, 0.005), 4);
  return name == "bar" ? shifted(make_capsule(0.008, 0.01, 12), Vec3(-0.05, 0, 0.0232))
                       : shifted(make_sphere(0.012, 2), Vec3(0.05, 0, 0.0172));
}

SceneRequest request(const std::string& text) {
  SceneRequest made;
  made.name = made.file = "test.toml";
  made.text = text;
  made.synthetic_mesh = mesh_of;
  return made;
}

std::string both() {
  return std::string(bones) + "[[muscle]]" + bar + "[[muscle]]" + ball + attachments_of_bar() +
         attachment("ball", 0.05);
}

TEST(ManyMuscles, AreRangesOfNodesAndTriangles) {
  const Scene scene = read_scene(request(both()));
  ASSERT_EQ(scene.muscles.size(), 2U);
  EXPECT_EQ(scene.muscle_names(), "bar + ball");
  const TriangleMesh bar_mesh = mesh_of("bar");
  const TriangleMesh ball_mesh = mesh_of("ball");
  const Body& first = scene.muscles[0].body;
  const Body& second = scene.muscles[1].body;
  EXPECT_EQ(scene.vertices_of(first), bar_mesh.vertices);
  EXPECT_EQ(scene.vertices_of(second), ball_mesh.vertices);
  EXPECT_EQ(scene.mesh_of(second).triangles, ball_mesh.triangles);
  EXPECT_EQ(second.first_node, first.last_node);
  EXPECT_EQ(second.first_triangle, first.last_triangle);
  ASSERT_EQ(scene.attachments.size(), 3U);
  for (const Attachment& attachment : scene.attachments) {
    ASSERT_FALSE(attachment.nodes.empty());
    for (const int node : attachment.nodes) {
      EXPECT_EQ(body_of(scene.bodies(), node), attachment.muscle);
    }
  }
}

/// Positions after some frames, by muscle.
std::vector<std::vector<Vec3>> simulated(const std::string& text, int threads) {
  const Scene scene = read_scene(request(text));
  const BackendEntry& entry = find_backend("bvh");
  const auto backend = entry.make(Parameters(entry.parameters, {}, "test"));
  backend->build(scene.bones, scene.muscle_mesh, threads);
  const PreparedSimulation prepared = prepare_simulation(scene, *backend, {entry.default_response}, threads);
  for (int frame = 1; frame <= scene.loop.frames; ++frame) {
    prepared.simulation->step_frame(frame);
  }
  std::vector<std::vector<Vec3>> positions;
  for (const Muscle& muscle : scene.muscles) {
    const std::vector<Vec3>& all = prepared.simulation->positions();
    positions.emplace_back(all.begin() + muscle.body.first_node, all.begin() + muscle.body.last_node);
  }
  return positions;
}

TEST(ManyMuscles, MoveToTheBitAsIfEachWereAlone) {
  const auto of_bar = simulated(std::string(bones) + "[muscle]" + bar + attachments_of_bar(), 1);
  const auto of_ball = simulated(std::string(bones) + "[muscle]" + ball + attachment("ball", 0.05), 1);
  for (const int threads : {1, 2, 3}) {
    const auto together = simulated(both(), threads);
    ASSERT_EQ(together.size(), 2U);
    EXPECT_EQ(together[0], of_bar[0]) << threads;
    EXPECT_EQ(together[1], of_ball[0]) << threads;
  }
  EXPECT_GT((of_bar[0][5] - mesh_of("bar").vertices[5]).norm(), 1e-3);
  EXPECT_GT((of_ball[0][5] - mesh_of("ball").vertices[5]).norm(), 1e-3);
}

/// The muscle with fibres comes second: its nodes are numbered from another one on.
TEST(ManyMuscles, MoveToTheBitAsIfEachWereAloneInAnyOrder) {
  const auto of_bar = simulated(std::string(bones) + "[muscle]" + bar + attachments_of_bar(), 1);
  const auto together = simulated(
      std::string(bones) + "[[muscle]]" + ball + "[[muscle]]" + bar + attachment("ball", 0.05) + attachments_of_bar(),
      2);
  ASSERT_EQ(together.size(), 2U);
  EXPECT_EQ(together[1], of_bar[0]);
}

TEST(ManyMuscles, ThatPassThroughEachOtherAreWarnedOf) {
  const auto mentions = [](const std::string& text, const std::string& what) {
    return std::ranges::any_of(scene_warnings(read_scene(request(text))),
                               [&](const std::string& line) { return line.find(what) != std::string::npos; });
  };
  EXPECT_TRUE(mentions(both(), "pass through each other"));
  EXPECT_FALSE(mentions(all_touch + both(), "pass through each other"));
  EXPECT_FALSE(mentions(std::string(bones) + "[muscle]" + bar + attachments_of_bar(), "pass through each other"));
}

TEST(ManyMuscles, PairsAreAllOrThoseThatAreNamed) {
  const Scene all = read_scene(request(all_touch + both()));
  ASSERT_EQ(all.muscle_pairs.size(), 1U);
  EXPECT_EQ(all.muscle_pairs[0].muscles, (MusclePair{0, 1}));
  EXPECT_EQ(all.muscle_pairs[0].backend.name, "");
  const Scene named = read_scene(request(both() + pair("ball", "bar", "backend = \"fcl\"")));
  ASSERT_EQ(named.muscle_pairs.size(), 1U);
  EXPECT_EQ(named.muscle_pairs[0].muscles, (MusclePair{0, 1}));
  EXPECT_EQ(named.muscle_pairs[0].backend.name, "fcl");
  EXPECT_TRUE(read_scene(request(both())).muscle_pairs.empty());
  EXPECT_EQ(read_scene(request("[contact]\nsteps = 7\n" + both())).response_steps, 7);
  EXPECT_FALSE(named.muscle_pairs[0].response_steps);
  EXPECT_EQ(read_scene(request(both() + pair("ball", "bar", "steps = 9"))).muscle_pairs[0].response_steps, 9);
}

TEST(ManyMuscles, ABoneMayHaveAResponseAndStepsOfItsOwn) {
  const auto with = [](const std::string& more) {
    std::string text = both();
    return request(text.replace(text.find("mesh = \"synthetic:lid\""), 0, more));
  };
  const Scene scene = read_scene(with("response = \"backtrack\"\nsteps = 5\n"));
  EXPECT_FALSE(scene.bone_contacts[0].response);
  EXPECT_EQ(scene.bone_contacts[1].response, ResponseKind::backtrack);
  const BoneResponse plate{ResponseKind::project, 3};
  EXPECT_EQ(scene.responses({ResponseKind::project}), (std::vector{plate, {ResponseKind::project, 5}}));
  EXPECT_EQ(scene.responses({ResponseKind::project, ResponseKind::backtrack}),
            (std::vector{plate, {ResponseKind::backtrack, 5}}));
  expect_mentions(error_of(with("response = \"bactrack\"\n")), {"bone[2].response", "did you mean 'backtrack'"});
  expect_mentions(error_of(with("steps = 0\n")), {"bone[2].steps"});
}

TEST(ManyMuscles, WhatIsWrongWithPairsNamesItsKey) {
  const std::string one = std::string(bones) + "[muscle]" + bar + attachments_of_bar();
  expect_mentions(error_of(request(all_touch + one)), {"contact.muscle_contact", "two muscles", "has one"});
  expect_mentions(error_of(request(both() + pair("ball", "bra"))),
                  {"test.toml", "pair[1].muscles", "'bra'", "did you mean 'bar'"});
  expect_mentions(error_of(request(both() + pair("ball", "ball"))), {"pair[1].muscles", "'ball' stands there twice"});
  expect_mentions(error_of(request(both() + pair("ball", "bar") + pair("bar", "ball"))),
                  {"pair[2].muscles", "earlier [[pair]]"});
  expect_mentions(error_of(request(both() + "[[pair]]\nmuscles = [\"ball\"]\n")), {"pair[1].muscles", "two muscles"});
  expect_mentions(error_of(request("[contact]\nmuscle_backend = \"bvh\"\n" + both())),
                  {"contact.muscle_backend", "no muscles touch"});
  for (const char* steps : {"0", "2.5", "1e9"}) {
    expect_mentions(error_of(request("[contact]\nsteps = " + std::string(steps) + "\n" + both())), {"contact.steps"});
    expect_mentions(error_of(request(both() + pair("ball", "bar", "steps = " + std::string(steps)))),
                    {"test.toml", "pair[1].steps"});
  }
  SceneRequest open = request(all_touch + both());
  open.synthetic_mesh = [](const std::string& name) {
    TriangleMesh mesh = mesh_of(name);
    if (name == "ball") mesh.triangles.erase(mesh.triangles.begin());
    return mesh;
  };
  expect_mentions(error_of(open), {"contact.muscle_contact", "muscle 'ball' is open"});
}

TEST(ColliderBackends, AreThoseOfTheOptionsBeforeTheSceneBeforeTheCase) {
  std::string text = all_touch + both();
  const Scene plain = read_scene(request(text));
  const BackendEntry& sdf = find_backend("sdf");
  const ColliderBackends by_default = choose_collider_backends({}, plain, sdf);
  EXPECT_TRUE(by_default.of_bones.empty());
  ASSERT_EQ(by_default.of_pairs.size(), 1U);
  EXPECT_EQ(by_default.of_pairs[0]->name, "bvh");
  const ColliderBackends by_option = choose_collider_backends({"lid=voxel", "muscles=brute_force"}, plain, sdf);
  ASSERT_EQ(by_option.of_bones.size(), 2U);
  EXPECT_FALSE(by_option.of_bones[0]);
  EXPECT_EQ(by_option.of_bones[1]->entry->name, "voxel");
  EXPECT_EQ(by_option.of_pairs[0]->name, "brute_force");
  text.replace(text.find("mesh = \"synthetic:lid\""), 0, "backend = \"bvh\"\n");
  const Scene own = read_scene(request(text));
  EXPECT_EQ(choose_collider_backends({}, own, sdf).of_bones[1]->entry->name, "bvh");
  EXPECT_EQ(choose_collider_backends({"lid=voxel"}, own, sdf).of_bones[1]->entry->name, "voxel");
  EXPECT_TRUE(choose_collider_backends({"lid=sdf"}, own, sdf).of_bones.empty());
}

TEST(ColliderBackends, HaveParametersOfTheirOwn) {
  const BackendEntry& sdf = find_backend("sdf");
  const Parameters coarse(sdf.parameters, {{"cells", std::int64_t{16}}}, "test");
  std::string text = both();
  text.replace(text.find("mesh = \"synthetic:lid\""), 0, "backend = \"sdf\"\nparameters = {cells = 24}\n");
  const Scene scene = read_scene(request(text));
  const ColliderBackends by_scene = choose_collider_backends({}, scene, sdf);
  ASSERT_EQ(by_scene.of_bones.size(), 2U);
  EXPECT_FALSE(by_scene.of_bones[0]);
  EXPECT_EQ(by_scene.of_bones[1]->parameters.integer("cells"), 24);
  const ColliderBackends by_option = choose_collider_backends({"lid=sdf:cells=32,precision=compact"}, scene, sdf);
  EXPECT_EQ(by_option.of_bones[1]->parameters.integer("cells"), 32);
  EXPECT_EQ(by_option.of_bones[1]->parameters.word("precision"), "compact");
  EXPECT_EQ(backend_of_bone(0, sdf, coarse, by_option).parameters.integer("cells"), 16);
  const auto backend = make_backend(sdf, coarse, by_option);
  backend->build(scene.bones, scene.muscle_mesh, 1);
  const std::vector<StructureError> errors = backend->structure_errors();
  ASSERT_EQ(errors.size(), 2U);
  EXPECT_GT(errors[1].bytes, 0U);
  const auto mistake = [&](std::string wrong) {
    std::string of_bone = both();
    of_bone.replace(of_bone.find("mesh = \"synthetic:lid\""), 0, wrong + "\n");
    try {
      (void)choose_collider_backends({}, read_scene(request(of_bone)), sdf);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  expect_mentions(mistake("backend = \"sdf\"\nparameters = {cels = 24}"),
                  {"test.toml", "bone[2].parameters", "cels", "did you mean 'cells'"});
  expect_mentions(mistake("parameters = {cells = 24}"), {"bone[2].parameters", "name it by `backend`"});
  expect_mentions(mistake("backend = \"sfd\""), {"test.toml", "bone[2].backend", "did you mean 'sdf'"});
}

/// Of a scene whose muscles touch, too: between them a replay detects nothing.
TEST(ColliderBackends, OfBonesAlone) {
  const Scene scene = read_scene(request(all_touch + both()));
  const BackendEntry& sdf = find_backend("sdf");
  EXPECT_TRUE(bone_backends({}, scene, sdf).of_pairs.empty());
  EXPECT_EQ(bone_backends({"lid=voxel"}, scene, sdf).of_bones[1]->entry->name, "voxel");
  EXPECT_THROW((void)bone_backends({"muscles=bvh"}, scene, sdf), InputError);
}

/// Without depths the lid can't project, without cells the plate can't backtrack: each does what it can.
TEST(ColliderBackends, OfDifferentResponsesRunTogether) {
  const Scene scene = read_scene(request(both()));
  const BackendEntry& bvh = find_backend("bvh");
  const Parameters parameters(bvh.parameters, {}, "test");
  const ColliderBackends colliders = choose_collider_backends({"lid=voxel"}, scene, bvh);
  const std::vector<ResponseKind> responses = choose_responses("", scene, bvh, parameters, colliders);
  EXPECT_EQ(responses, (std::vector{ResponseKind::project, ResponseKind::backtrack}));
  const auto backend = make_backend(bvh, parameters, colliders);
  backend->build(scene.bones, scene.muscle_mesh, 1);
  const PreparedSimulation prepared = prepare_simulation(scene, *backend, responses, 1);
  std::vector<bool> met(scene.bones.size(), false);
  for (int frame = 1; frame <= scene.loop.frames; ++frame) {
    prepared.simulation->step_frame(frame);
    for (const Contact& contact : prepared.simulation->contacts()) met[static_cast<std::size_t>(contact.bone)] = true;
  }
  EXPECT_TRUE(met[0] || met[1]);
  for (const Vec3& position : prepared.simulation->positions()) ASSERT_TRUE(position.allFinite());
}

TEST(ColliderBackends, WhatCannotBeIsRefused) {
  const Scene scene = read_scene(request(all_touch + both()));
  const Scene apart = read_scene(request(both()));
  const BackendEntry& sdf = find_backend("sdf");
  const auto refusal = [&](const Scene& of, const std::string& option) -> std::string {
    try {
      (void)choose_collider_backends({option}, of, sdf);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  expect_mentions(refusal(scene, "muscles=sdf"), {"--for muscles=sdf", "can't follow a surface that deforms", "bvh"});
  expect_mentions(refusal(scene, "lidd=sdf"), {"--for lidd=sdf", "'lidd' is not a bone", "did you mean 'lid'"});
  expect_mentions(refusal(scene, "lid=sfd"), {"--for lid=sfd", "did you mean 'sdf'"});
  expect_mentions(refusal(scene, "lid"), {"--for lid", "COLLIDER=BACKEND"});
  expect_mentions(refusal(scene, "lid=sdf:"), {"--for lid=sdf:", "COLLIDER=BACKEND"});
  expect_mentions(refusal(scene, "lid=sdf:cels=3"), {"--for lid=sdf:cels=3", "did you mean 'cells'"});
  expect_mentions(refusal(scene, "muscles=bvh:x=1"), {"--for muscles=bvh:x=1", "leave the parameters out"});
  expect_mentions(refusal(apart, "muscles=bvh"), {"--for muscles=bvh", "no muscles of this scene touch"});
  const std::string named = both() + pair("ball", "bar", "backend = \"sdf\"");
  for (const std::string& text : {named, "[contact]\nmuscle_contact = true\nmuscle_backend = \"sdf\"\n" + both()}) {
    const Scene unable = read_scene(request(text));
    try {
      (void)choose_collider_backends({}, unable, sdf);
      ADD_FAILURE() << "not refused";
    } catch (const InputError& error) {
      expect_mentions(error.what(), {"test.toml", "backend", "can't follow a surface that deforms", "bvh"});
    }
  }
}

TEST(ManyMuscles, WhatIsWrongWithThemNamesItsKey) {
  const std::string two = std::string(bones) + "[[muscle]]" + bar + "[[muscle]]";
  expect_mentions(error_of(request(two + bar)), {"test.toml", "muscle[2].name", "'bar'", "earlier muscle"});
  std::string nameless = both();
  nameless.erase(nameless.find("muscle = \"ball\"\n"), std::string("muscle = \"ball\"\n").size());
  expect_mentions(error_of(request(nameless)), {"attachment[3].muscle", "is missing", "bar or ball"});
  std::string wrong = both();
  wrong.replace(wrong.find("muscle = \"ball\""), std::string("muscle = \"ball\"").size(), "muscle = \"balll\"");
  expect_mentions(error_of(request(wrong)), {"attachment[3].muscle", "'balll'", "did you mean 'ball'"});
  expect_mentions(error_of(request("muscle = []\n" + std::string(bones))), {"muscle", "[[muscle]]"});
}

}  // namespace
}  // namespace musclebench

// Who detects contacts between which muscle and bone, and between which muscles.
#include "bench/cases/collider_backends.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bench/cases/tests/bar_and_ball.hpp"
#include "core/base/input_error.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/scene/tests/scene_errors.hpp"

namespace musclebench {
namespace {

using namespace bar_and_ball;

TEST(ColliderBackends, AreThoseOfTheOptionsBeforeTheSceneBeforeTheCase) {
  std::string text = all_touch + both();
  const Scene plain = read_scene(request(text));
  const BackendEntry& sdf = find_backend("sdf");
  const ColliderBackends by_default = choose_collider_backends({}, plain, sdf);
  EXPECT_TRUE(by_default.with_bones.empty());
  ASSERT_EQ(by_default.of_muscle_pairs.size(), 1U);
  EXPECT_EQ(by_default.of_muscle_pairs[0].entry->name, "bvh");
  const ColliderBackends by_option = choose_collider_backends({"lid=voxel", "muscles=brute_force"}, plain, sdf);
  ASSERT_EQ(by_option.with_bones.size(), 4U);
  for (std::size_t muscle = 0; muscle < 2; ++muscle) {
    EXPECT_FALSE(by_option.with_bones[plain.bone_pair(muscle, 0)]);
    EXPECT_EQ(by_option.with_bones[plain.bone_pair(muscle, 1)]->entry->name, "voxel");
  }
  EXPECT_EQ(by_option.of_muscle_pairs[0].entry->name, "brute_force");
  text.replace(text.find("mesh = \"synthetic:lid\""), 0, "backend = \"bvh\"\n");
  const Scene own = read_scene(request(text));
  EXPECT_EQ(choose_collider_backends({}, own, sdf).with_bones[1]->entry->name, "bvh");
  EXPECT_EQ(choose_collider_backends({"lid=voxel"}, own, sdf).with_bones[1]->entry->name, "voxel");
  EXPECT_TRUE(choose_collider_backends({"lid=sdf"}, own, sdf).with_bones.empty());
}

TEST(ColliderBackends, HaveParametersOfTheirOwn) {
  const BackendEntry& sdf = find_backend("sdf");
  const Parameters coarse(sdf.parameters, {{"cells", std::int64_t{16}}}, "test");
  std::string text = both();
  text.replace(text.find("mesh = \"synthetic:lid\""), 0, "backend = \"sdf\"\nparameters = {cells = 24}\n");
  const Scene scene = read_scene(request(text));
  const ColliderBackends by_scene = choose_collider_backends({}, scene, sdf);
  ASSERT_EQ(by_scene.with_bones.size(), 4U);
  EXPECT_FALSE(by_scene.with_bones[0]);
  EXPECT_EQ(by_scene.with_bones[1]->parameters.integer("cells"), 24);
  const ColliderBackends by_option = choose_collider_backends({"lid=sdf:cells=32,margin=0.01"}, scene, sdf);
  EXPECT_EQ(by_option.with_bones[1]->parameters.integer("cells"), 32);
  EXPECT_EQ(by_option.with_bones[1]->parameters.number("margin"), 0.01);
  EXPECT_EQ(backend_of_pair(0, sdf, coarse, by_option).parameters.integer("cells"), 16);
  const auto backend = make_backend(scene, sdf, coarse, by_option);
  backend->build(scene.bones, scene.muscle_mesh, 1);
  const std::vector<StructureError> errors = backend->structure_errors();
  ASSERT_EQ(errors.size(), 2U);
  EXPECT_GT(errors[1].bytes, 0U);
  const auto mistake = [&](const std::string& wrong) {
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

/// Without depths the lid can't project, without cells the plate can't backtrack: each does what it can.
TEST(ColliderBackends, OfDifferentResponsesRunTogether) {
  const Scene scene = read_scene(request(both()));
  const BackendEntry& bvh = find_backend("bvh");
  const Parameters parameters(bvh.parameters, {}, "test");
  const ColliderBackends colliders = choose_collider_backends({"lid=voxel"}, scene, bvh);
  const std::vector<ResponseKind> responses = choose_responses("", scene, bvh, parameters, colliders);
  EXPECT_EQ(responses, (std::vector{ResponseKind::project, ResponseKind::backtrack, ResponseKind::project,
                                    ResponseKind::backtrack}));
  const auto backend = make_backend(scene, bvh, parameters, colliders);
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

TEST(ColliderBackends, FacesHaveTheirOwn) {
  const BackendEntry& bvh = find_backend("bvh");
  const Scene scene = read_scene(request("[effects.surface_contact]\n" + both()));
  EXPECT_FALSE(make_contact_methods(scene, choose_collider_backends({}, scene, bvh), 1).make_surface_queries);
  const ColliderBackends colliders = choose_collider_backends({"faces=sdf:cells=16"}, scene, bvh);
  EXPECT_TRUE(colliders.with_bones.empty());
  ASSERT_TRUE(colliders.of_faces);
  EXPECT_EQ(colliders.of_faces->parameters.integer("cells"), 16);
  const auto queries = make_contact_methods(scene, colliders, 1).make_surface_queries(scene.bones[0], 1);
  const Vec3 middle = bounding_box(scene.bones[0].surface.mesh.vertices).center();
  EXPECT_LT(queries->locate(middle, -1).signed_distance_m, 0);
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
  expect_mentions(refusal(scene, "muscles=bvh:x=1"), {"--for muscles=bvh:x=1", "x"});
  expect_mentions(refusal(scene, "bar/lidd=sdf"), {"--for bar/lidd=sdf", "did you mean 'bar/lid'"});
  expect_mentions(refusal(apart, "bar/ball=bvh"), {"--for bar/ball=bvh", "of muscles that touch"});
  expect_mentions(refusal(apart, "muscles=bvh"), {"--for muscles=bvh", "no muscles of this scene touch"});
  expect_mentions(refusal(apart, "faces=bvh"), {"--for faces=bvh", "[effects.surface_contact]"});
  const Scene faces = read_scene(request("[effects.surface_contact]\n" + both()));
  expect_mentions(refusal(faces, "faces=voxel"), {"--for faces=voxel", "does not answer for faces", "bvh", "sdf"});
  expect_mentions(refusal(faces, "faces=sdf:clearance_cache=off"), {"'clearance_cache' changes nothing for faces"});
  expect_mentions(refusal(faces, "faces=sdf:cell_size_m=10"), {"--for faces=sdf:cell_size_m=10"});
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

std::string bone_pair(const std::string& muscle, const std::string& bone, const std::string& more) {
  return "\n[[pair]]\nmuscle = \"" + muscle + "\"\nbone = \"" + bone + "\"\n" + more + "\n";
}

TEST(ColliderBackends, OfAMuscleAndABoneComeBeforeThoseOfTheBone) {
  const BackendEntry& bvh = find_backend("bvh");
  const auto backend_of = [&](const std::string& text, const std::vector<std::string>& options, std::size_t muscle) {
    const Scene scene = read_scene(request(text));
    const ColliderBackends colliders = choose_collider_backends(options, scene, bvh);
    return backend_of_pair(scene.bone_pair(muscle, 1), bvh, Parameters(bvh.parameters, {}, "test"), colliders)
        .entry->name;
  };
  const std::string by_scene = both() + bone_pair("ball", "lid", "backend = \"sdf\"\nparameters = {cells = 16}");
  EXPECT_EQ(backend_of(by_scene, {}, 0), "bvh");
  EXPECT_EQ(backend_of(by_scene, {}, 1), "sdf");
  std::string with_bone = by_scene;
  with_bone.replace(with_bone.find("mesh = \"synthetic:lid\""), 0, "backend = \"voxel\"\n");
  EXPECT_EQ(backend_of(with_bone, {}, 0), "voxel");
  EXPECT_EQ(backend_of(with_bone, {}, 1), "sdf");
  EXPECT_EQ(backend_of(with_bone, {"lid=brute_force"}, 1), "brute_force");
  EXPECT_EQ(backend_of(with_bone, {"lid=brute_force", "ball/lid=null"}, 0), "brute_force");
  EXPECT_EQ(backend_of(with_bone, {"lid=brute_force", "ball/lid=null"}, 1), "null");
  const Scene scene = read_scene(request(by_scene));
  const ColliderBackends colliders = choose_collider_backends({}, scene, bvh);
  EXPECT_EQ(colliders.with_bones[scene.bone_pair(1, 1)]->parameters.integer("cells"), 16);
}

TEST(ColliderBackends, OfAMuscleAndABoneAreAskedAboutThatMuscleOnly) {
  const Scene scene = read_scene(request(both()));
  const BackendEntry& bvh = find_backend("bvh");
  const Parameters parameters(bvh.parameters, {}, "test");
  // Down into the plate, up into the lid.
  std::vector<Vec3> positions = scene.muscle_mesh.vertices;
  for (Vec3& position : positions) position.z() += position.z() > 0.03 ? 0.008 : -0.008;
  std::vector<int> nodes;
  for (int node = 0; node < static_cast<int>(positions.size()); ++node) nodes.push_back(node);
  const auto contacts_with = [&](const std::vector<std::string>& options) {
    const auto backend = make_backend(scene, bvh, parameters, choose_collider_backends(options, scene, bvh));
    backend->build(scene.bones, scene.muscle_mesh, 1);
    backend->update(std::vector<RigidMotion>(2), positions);
    std::vector<Contact> contacts;
    backend->detect(positions, nodes, contacts);
    return contacts;
  };
  const auto expect_those_of = [&](const std::vector<Contact>& found, const std::vector<Contact>& others, int bone,
                                   std::size_t muscle) {
    const auto own = [&](const std::vector<Contact>& contacts) {
      std::vector<Contact> chosen;
      std::ranges::copy_if(contacts, std::back_inserter(chosen), [&](const Contact& contact) {
        return contact.bone == bone && body_of(scene.bodies(), contact.node) == muscle;
      });
      return chosen;
    };
    const std::vector<Contact> expected = own(others);
    const std::vector<Contact> answered = own(found);
    ASSERT_EQ(answered.size(), expected.size()) << bone << " " << muscle;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(answered[i].node, expected[i].node);
      EXPECT_EQ(answered[i].depth_m, expected[i].depth_m);
      EXPECT_EQ(answered[i].normal, expected[i].normal);
    }
  };
  const std::vector<Contact> exact = contacts_with({});
  std::vector<std::string> others = {"sdf:cells=16", "voxel", "brute_force"};
  if (std::ranges::any_of(backend_registry(), [](const BackendEntry& entry) { return entry.name == "fcl"; })) {
    others.emplace_back("fcl");
  }
  for (const std::string& other : others) {
    const std::vector<Contact> all_other = contacts_with({"plate=" + other, "lid=" + other});
    const std::vector<Contact> mixed = contacts_with({"ball/plate=" + other});
    ASSERT_GT(all_other.size(), 20U) << other;
    EXPECT_TRUE(std::ranges::is_sorted(mixed, {},
                                       [](const Contact& contact) { return std::pair(contact.bone, contact.node); }));
    expect_those_of(mixed, exact, 0, 0);
    expect_those_of(mixed, all_other, 0, 1);
    expect_those_of(mixed, exact, 1, 0);
    expect_those_of(contacts_with({"bar/lid=" + other, "bar/plate=" + other}), all_other, 1, 0);
  }
}

TEST(ColliderBackends, BuildAStructureOverABoneOnceForEachBackend) {
  const Scene scene = read_scene(request(both()));
  const BackendEntry& bvh = find_backend("bvh");
  const auto fields = [&](const std::vector<std::string>& options) {
    const auto backend =
        make_backend(scene, bvh, Parameters(bvh.parameters, {}, "test"), choose_collider_backends(options, scene, bvh));
    backend->build(scene.bones, scene.muscle_mesh, 1);
    std::vector<std::string> bones_of_fields;
    for (const StructureError& error : backend->structure_errors()) bones_of_fields.push_back(error.bone);
    return bones_of_fields;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(fields({"bar/lid=sdf:cells=16"}), Names{"lid"});
  EXPECT_EQ(fields({"bar/lid=sdf:cells=16", "ball/lid=sdf:cells=16"}), Names{"lid"});
  EXPECT_EQ(fields({"bar/lid=sdf:cells=16", "ball/lid=sdf:cells=24"}), (Names{"lid", "lid"}));
  EXPECT_EQ(fields({"ball/plate=sdf:cells=16", "ball/lid=sdf:cells=16"}), (Names{"plate", "lid"}));
}

/// Each muscle has its own backend and response on the plate, and moves as if it were alone with them.
TEST(ColliderBackends, OfMusclesMoveThemAsIfEachWereAlone) {
  const auto of_bar =
      simulated(std::string(bones) + "[muscle]" + bar + attachments_of_bar(), 1, {"plate=voxel", "lid=sdf:cells=16"});
  const auto of_ball = simulated(std::string(bones) + "[muscle]" + ball + attachment("ball", 0.05), 1);
  for (const int threads : {1, 2}) {
    const auto together = simulated(both(), threads, {"bar/plate=voxel", "bar/lid=sdf:cells=16"});
    EXPECT_EQ(together[0], of_bar[0]) << threads;
    EXPECT_EQ(together[1], of_ball[0]) << threads;
  }
  EXPECT_NE(of_bar[0], simulated(both(), 1)[0]);
}

TEST(ColliderBackends, APairOfMuscleAndBoneHasResponseAndStepsOfItsOwn) {
  const Scene scene = read_scene(request(both() + bone_pair("ball", "plate", "response = \"backtrack\"\nsteps = 5")));
  const BackendEntry& sdf = find_backend("sdf");
  const Parameters parameters(sdf.parameters, {}, "test");
  const auto kinds = choose_responses("", scene, sdf, parameters);
  const BoneResponse usual{ResponseKind::project, 3};
  EXPECT_EQ(scene.responses(kinds), (std::vector{usual, usual, {ResponseKind::backtrack, 5}, usual}));
  const BackendEntry& bvh = find_backend("bvh");
  try {
    (void)choose_responses("", scene, bvh, Parameters(bvh.parameters, {}, "test"));
    ADD_FAILURE() << "not refused";
  } catch (const InputError& error) {
    expect_mentions(error.what(), {"test.toml", "pair[1].response", "'bvh' has no cells"});
  }
}

TEST(ColliderBackends, BetweenMusclesHaveParametersOfTheirOwn) {
  const BackendEntry& sdf = find_backend("sdf");
  const std::string uncached = "backend = \"bvh\"\nparameters = {clearance_cache = \"off\"}";
  const Scene scene = read_scene(request(both() + pair("ball", "bar", uncached)));
  const auto keeps_clearances = [&](const std::vector<std::string>& options) {
    return choose_collider_backends(options, scene, sdf).of_muscle_pairs[0].parameters.word("clearance_cache") == "on";
  };
  EXPECT_FALSE(keeps_clearances({}));
  EXPECT_TRUE(keeps_clearances({"muscles=bvh"}));
  EXPECT_FALSE(keeps_clearances({"muscles=bvh:clearance_cache=off"}));
  EXPECT_FALSE(keeps_clearances({"muscles=bvh", "ball/bar=bvh:clearance_cache=off"}));
  EXPECT_TRUE(keeps_clearances({"bar/ball=bvh"}));
  const auto detector = [&](const std::vector<std::string>& options) {
    return make_muscle_detectors(scene, choose_collider_backends(options, scene, sdf), 1).front()->structure_bytes();
  };
  EXPECT_LT(detector({}), detector({"muscles=bvh"}));
}

TEST(ColliderBackends, WhatIsWrongWithAPairNamesItsKey) {
  const BackendEntry& sdf = find_backend("sdf");
  const auto refusal = [&](const std::string& more, const std::vector<std::string>& options = {}) -> std::string {
    try {
      (void)choose_collider_backends(options, read_scene(request(both() + more)), sdf);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  expect_mentions(refusal(bone_pair("ball", "lidd", "steps = 4")),
                  {"test.toml", "pair[1].bone", "'lidd' is not a bone", "did you mean 'lid'"});
  expect_mentions(refusal(bone_pair("bll", "lid", "steps = 4")), {"pair[1].muscle", "did you mean 'ball'"});
  expect_mentions(refusal(bone_pair("ball", "lid", "")), {"test.toml", "pair[1]", "says nothing", "steps"});
  expect_mentions(refusal(bone_pair("ball", "lid", "steps = 4") + bone_pair("ball", "lid", "steps = 5")),
                  {"pair[2].bone", "earlier [[pair]]"});
  expect_mentions(refusal("\n[[pair]]\nsteps = 4\n"), {"pair[1]", "two muscles", "a muscle and a bone"});
  expect_mentions(refusal(bone_pair("ball", "lid", "muscles = [\"ball\", \"bar\"]")), {"pair[1]", "two muscles"});
  expect_mentions(refusal(bone_pair("ball", "lid", "backend = \"sfd\"")), {"pair[1].backend", "did you mean 'sdf'"});
  expect_mentions(refusal(bone_pair("ball", "lid", "parameters = {cells = 3}")),
                  {"pair[1].parameters", "name it by `backend`"});
  expect_mentions(refusal(bone_pair("ball", "lid", "backend = \"sdf\"\nparameters = {cels = 3}")),
                  {"test.toml", "pair[1].parameters", "did you mean 'cells'"});
  expect_mentions(refusal(pair("ball", "bar", "backend = \"bvh\"\nparameters = {clearance_cash = false}")),
                  {"test.toml", "pair[1].parameters", "did you mean 'clearance_cache'"});
  if (std::ranges::any_of(backend_registry(), [](const BackendEntry& entry) { return entry.name == "fcl"; })) {
    for (const char* useless : {"query = \"node_distance\"", "manager = \"none\""}) {
      expect_mentions(refusal(pair("ball", "bar", "backend = \"fcl\"\nparameters = {" + std::string(useless) + "}")),
                      {"test.toml", "pair[1].parameters", "fcl: "});
    }
    expect_mentions(refusal(pair("ball", "bar"), {"muscles=fcl:query=node_distance"}),
                    {"--for muscles=fcl:query=node_distance", "needs query = surfaces"});
  }
}

}  // namespace
}  // namespace musclebench

// Backend and response are chosen apart.
#include "bench/cases/case.hpp"

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/effects/effect_registry.hpp"

namespace musclebench {
namespace {

ResponseKind chosen(const std::string& backend, const std::string& option, std::optional<ResponseKind> of_scene = {}) {
  Scene scene;
  scene.name = "knee";
  scene.response = of_scene;
  const BackendEntry& entry = find_backend(backend);
  return choose_responses(option, scene, entry, Parameters(entry.parameters, {}, "test")).front();
}

std::string refusal(const std::string& backend, const std::string& option, std::optional<ResponseKind> of_scene = {}) {
  try {
    (void)chosen(backend, option, of_scene);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ChooseResponse, TheCommandLineBeforeTheSceneBeforeTheBackend) {
  EXPECT_EQ(chosen("sdf", ""), ResponseKind::project);
  EXPECT_EQ(chosen("voxel", ""), ResponseKind::backtrack);
  EXPECT_EQ(chosen("sdf", "", ResponseKind::backtrack), ResponseKind::backtrack);
  EXPECT_EQ(chosen("sdf", "project", ResponseKind::backtrack), ResponseKind::project);
  EXPECT_EQ(chosen("null", "backtrack"), ResponseKind::backtrack);
}

TEST(ChooseResponse, WhatABackendCannotServeIsRefusedWithTheReason) {
  EXPECT_EQ(refusal("voxel", "project"),
            "--response project: 'voxel' has no depth to project by; take 'backtrack', or another backend");
  EXPECT_NE(refusal("bvh", "backtrack").find("no cells whose size is the step back"), std::string::npos);
  EXPECT_NE(refusal("bvh", "", ResponseKind::backtrack).find("knee: contact.response: 'bvh'"), std::string::npos);
  EXPECT_NE(refusal("sdf", "projekt").find("did you mean 'project'"), std::string::npos);
}

BackendChoice default_choice(const std::string& name) {
  const BackendEntry& entry = find_backend(name);
  return {&entry, Parameters(entry.parameters, {}, name)};
}

/// Two bones: what is chosen for each, and what is said where that can't be.
struct TwoBones {
  Scene scene;
  ColliderBackends colliders = {};

  TwoBones() {
    scene.name = "knee";
    scene.bones.resize(2);
    scene.bones[1].name = "tibia";
    scene.bone_contacts.resize(2);
  }
  [[nodiscard]] std::vector<ResponseKind> chosen(const std::string& backend, const std::string& option = "") const {
    const BackendEntry& entry = find_backend(backend);
    return choose_responses(option, scene, entry, Parameters(entry.parameters, {}, "test"), colliders);
  }
  [[nodiscard]] std::string refusal(const std::string& backend, const std::string& option = "") const {
    try {
      (void)chosen(backend, option);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
};

using Kinds = std::vector<ResponseKind>;

TEST(ChooseResponse, ABonesOwnComesFirst) {
  TwoBones two;
  EXPECT_EQ(two.chosen("sdf"), Kinds{ResponseKind::project});
  two.scene.bone_contacts[1].response = ResponseKind::backtrack;
  two.scene.bone_contacts[1].response_location = "knee.toml:7: bone[2].response";
  EXPECT_EQ(two.chosen("sdf"), (Kinds{ResponseKind::project, ResponseKind::backtrack}));
  EXPECT_EQ(two.chosen("sdf", "backtrack"), Kinds{ResponseKind::backtrack});
  EXPECT_NE(two.refusal("bvh").find("knee.toml:7: bone[2].response: 'bvh' has no cells"), std::string::npos);
}

TEST(ChooseResponse, ABoneWithABackendOfItsOwnHasTheResponseOfThat) {
  TwoBones two;
  two.colliders.with_bones = {std::nullopt, default_choice("voxel")};
  EXPECT_EQ(two.chosen("bvh"), (Kinds{ResponseKind::project, ResponseKind::backtrack}));
  EXPECT_EQ(two.chosen("voxel"), Kinds{ResponseKind::backtrack});
  EXPECT_NE(two.refusal("bvh", "backtrack").find("'bvh' has no cells"), std::string::npos);
  two.scene.response = ResponseKind::project;
  EXPECT_NE(two.refusal("bvh").find("'voxel' has no depth"), std::string::npos);
}

/// Every row can be paired with the response that is its own.
TEST(ChooseResponse, EveryBackendServesItsOwn) {
  for (const BackendEntry& entry : backend_registry()) {
    EXPECT_EQ(refusal(entry.name, std::string(name_of(entry.default_response))), "") << entry.name;
  }
}

TEST(RequireWhatEffectsNeed, WhatABackendOrAResponseLacksIsSaidWithACure) {
  TwoBones knee;
  const auto refused = [&](const std::string& backend, ResponseKind response) -> std::string {
    try {
      const auto [entry, parameters] = default_choice(backend);
      require_what_effects_need(knee.scene, *entry, parameters, {response}, knee.colliders);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const auto add = [&](const std::string& name) {
    knee.scene.effects.push_back({name, Parameters(find_effect(name)->parameters, {}, "test")});
  };
  add("tunnelling_guard");
  EXPECT_EQ(refused("voxel", ResponseKind::backtrack), "");
  add("friction");
  EXPECT_EQ(refused("sdf", ResponseKind::backtrack), "");
  EXPECT_EQ(refused("voxel", ResponseKind::backtrack),
            "knee: effects.friction: needs the normals of contacts, and 'voxel' tells none; take another backend; or "
            "write `friction = false`");
  add("margin");
  EXPECT_EQ(refused("sdf", ResponseKind::project), "");
  EXPECT_EQ(refused("sdf", ResponseKind::backtrack),
            "knee: effects.margin: needs a response that moves nodes by their depths; take 'project'; or write `margin "
            "= false`");
  knee.colliders.with_bones = {std::nullopt, default_choice("voxel")};
  EXPECT_NE(refused("sdf", ResponseKind::project).find("'voxel' tells none"), std::string::npos);
}

TEST(EffectsWithoutContacts, AreThoseThatLookAtContactsWhereNoneIsFound) {
  TwoBones knee;
  for (const char* name : {"bending", "friction"}) {
    knee.scene.effects.push_back({name, Parameters(find_effect(name)->parameters, {}, "test")});
  }
  const auto idle = [&](const std::string& backend) {
    const auto [entry, parameters] = default_choice(backend);
    return effects_without_contacts(knee.scene, *entry, parameters, knee.colliders);
  };
  EXPECT_EQ(idle("null"), std::vector<std::string>{"knee: effects.friction: looks at contacts with bones, and 'null' "
                                                   "finds none: it changes nothing"});
  EXPECT_TRUE(idle("bvh").empty());
  knee.colliders.with_bones = {std::nullopt, default_choice("bvh")};
  EXPECT_TRUE(idle("null").empty());
}

}  // namespace
}  // namespace musclebench

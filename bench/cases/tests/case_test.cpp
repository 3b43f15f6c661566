// Backend and response are chosen apart.
#include "bench/cases/case.hpp"

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"

namespace musclebench {
namespace {

ResponseKind chosen(const std::string& backend, const std::string& option, std::optional<ResponseKind> of_scene = {}) {
  Scene scene;
  scene.name = "knee";
  scene.response = of_scene;
  const BackendEntry& entry = find_backend(backend);
  return choose_response(option, scene, entry, Parameters(entry.parameters, {}, "test"));
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

/// Every row can be paired with the response that is its own.
TEST(ChooseResponse, EveryBackendServesItsOwn) {
  for (const BackendEntry& entry : backend_registry()) {
    EXPECT_EQ(refusal(entry.name, std::string(name_of(entry.default_response))), "") << entry.name;
  }
}

}  // namespace
}  // namespace musclebench

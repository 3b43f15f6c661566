#include "core/scene/effect_override.hpp"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/scene/tests/scene_errors.hpp"

namespace musclebench {
namespace {

SceneEffect effect(const std::string& name, const std::map<std::string, ParameterValue>& given = {}) {
  return {name, Parameters(find_effect(name)->parameters, given, "test")};
}

std::vector<std::string> names(const std::vector<SceneEffect>& effects) {
  std::vector<std::string> found;
  for (const SceneEffect& each : effects) found.push_back(each.name);
  return found;
}

std::string error_of(const std::vector<EffectOverride>& changes) {
  std::vector<SceneEffect> effects = {effect("gravity"), effect("bending")};
  try {
    override_effects(changes, effects);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(EffectOverride, AddsInTheOrderOfTheRegistryAndRemoves) {
  std::vector<SceneEffect> effects = {effect("gravity"), effect("bending")};
  override_effects({{"", "friction"}, {"", "volume"}, {"", "gravity", true}}, effects);
  EXPECT_EQ(names(effects), (std::vector<std::string>{"volume", "bending", "friction"}));
  EXPECT_EQ(effects[0].parameters.number("pressure"), 1.0);
}

TEST(EffectOverride, ChangesOneValueAndKeepsTheOthers) {
  std::vector<SceneEffect> effects = {effect("gravity", {{"x_m_per_s2", 1.0}, {"y_m_per_s2", 2.0}})};
  override_effects({{"", "gravity", false, {{"y_m_per_s2", 3.0}}}}, effects);
  ASSERT_EQ(effects.size(), 1U);
  EXPECT_EQ(effects[0].parameters.number("x_m_per_s2"), 1.0);
  EXPECT_EQ(effects[0].parameters.number("y_m_per_s2"), 3.0);
  EXPECT_TRUE(effects[0].parameters.given("x_m_per_s2"));
  EXPECT_FALSE(effects[0].parameters.given("z_m_per_s2"));
}

TEST(EffectOverride, RefusesWithOptionAndCure) {
  expect_mentions(error_of({{"--effect gravty", "gravty"}}), {"--effect gravty", "did you mean 'gravity'"});
  expect_mentions(error_of({{"--effect volume:presure=2", "volume", false, {{"presure", 2.0}}}}),
                  {"--effect volume:presure=2", "presure", "pressure"});
  expect_mentions(error_of({{"--effect volume:pressure=0", "volume", false, {{"pressure", 0.0}}}}),
                  {"pressure", "0.01"});
  expect_mentions(error_of({{"--effect volume", "volume"}, {"--no-effect volume", "volume", true}}),
                  {"--no-effect volume", "a second time", "leave one out"});
  expect_mentions(error_of({{"--no-effect volume", "volume", true}}), {"--no-effect volume", "neither the scene"});
  EXPECT_EQ(error_of({{"--no-effect bending", "bending", true}}), "no error");
}

}  // namespace
}  // namespace musclebench

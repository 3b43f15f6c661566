#include "core/scene/check/effect_reach.hpp"

#include <map>

#include <gtest/gtest.h>

#include "core/scene/check/tests/check_fixture.hpp"

namespace musclebench {
namespace {

constexpr const char* plate_bone = "[[bone]]\nname = \"plate\"\nmesh = \"synthetic:plate\"\n";
constexpr const char* one_muscle = "[[muscle]]\nname = \"ball\"\nmesh = \"synthetic:ball\"\n";
constexpr const char* second_muscle =
    "[[muscle]]\nname = \"far\"\nmesh = \"synthetic:far\"\n[contact]\nmuscle_contact = true\n";

std::map<std::string, std::string> reaches(const std::string& text) {
  const Scene scene = check_scene_of(text);
  std::map<std::string, std::string> told;
  for (const EffectReach& reach : effect_reaches(scene)) told[std::string(reach.effect)] = reach.text();
  return told;
}

TEST(EffectReach, OfContactWithABoneAloneIsItsNodes) {
  const auto told = reaches(std::string(plate_bone) + one_muscle +
                            "[effects.friction]\n[effects.margin]\n[effects.tunnelling_guard]\n[effects.gravity]\n");
  EXPECT_EQ(told.size(), 3U) << "gravity is no contact";
  for (const auto& [effect, text] : told) EXPECT_EQ(text, "nodes against bones") << effect;
}

TEST(EffectReach, GrowsWithTheContactsOfOtherEffects) {
  const auto told =
      reaches(std::string(plate_bone) + one_muscle + second_muscle +
              "[effects.friction]\n[effects.margin]\n[effects.self_contact]\n[effects.surface_contact]\n");
  EXPECT_EQ(told.at("friction"),
            "nodes, faces and edges against bones; muscles against each other; each muscle against itself");
  EXPECT_EQ(told.at("margin"), "nodes, faces and edges against bones");
  EXPECT_EQ(told.at("self_contact"), "each muscle against itself");
  EXPECT_EQ(told.at("surface_contact"), "faces and edges against bones");
}

TEST(EffectReach, OfNoPassageIsWhatItIsAskedFor) {
  const std::string scene =
      std::string(plate_bone) + one_muscle + second_muscle + "[effects.friction]\n[effects.no_passage]\n";
  EXPECT_EQ(reaches(scene).at("no_passage"),
            "nodes, faces and edges against bones; muscles against each other; each muscle against itself");
  EXPECT_EQ(reaches(scene).at("friction"), reaches(scene).at("no_passage"));
  EXPECT_EQ(reaches(scene + "itself = false\n").at("friction"),
            "nodes, faces and edges against bones; muscles against each other");
}

TEST(EffectReach, OfMultiBoneWithOneBoneIsNothing) {
  const Scene scene = check_scene_of(std::string(plate_bone) + one_muscle + "[effects.multi_bone]\n");
  ASSERT_EQ(effect_reaches(scene).size(), 1U);
  EXPECT_TRUE(effect_reaches(scene).front().is_inert());
  EXPECT_EQ(effect_reaches(scene).front().text(), "nothing");
}

}  // namespace
}  // namespace musclebench

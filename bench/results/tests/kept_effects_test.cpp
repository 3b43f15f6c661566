#include "bench/results/kept_effects.hpp"

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "bench/results/tests/small_run.hpp"
#include "core/base/temporary_folder.hpp"
#include "core/scene/check/auto_effects.hpp"

namespace musclebench {
namespace {

namespace fs = std::filesystem;

Scene two_balls_near_a_bone() {
  Scene scene = plain_scene();
  scene.add_muscle("other", make_sphere(0.02, 1));
  scene.bone_contacts.resize(2);
  return scene;
}

/// With the cache in a folder of its own.
class KeptEffects : public testing::Test {
 protected:
  void SetUp() override {
    if (const char* before = std::getenv("XDG_CACHE_HOME")) m_before = before;
    setenv("XDG_CACHE_HOME", m_folder.path().c_str(), 1);
  }
  void TearDown() override { m_before ? setenv("XDG_CACHE_HOME", m_before->c_str(), 1) : unsetenv("XDG_CACHE_HOME"); }

  static EffectChoice added_to(Scene& scene) {
    add_effect(scene, {"surface_contact", {{"skin_m", 1.25e-4}}}, "trial", "it was deep");
    add_muscle_contact(scene, {0, 1}, "trial", "they passed");
    EffectChoice choice;
    choice.added = scene.auto_effects.added;
    choice.judged_all_frames = true;
    choice.unmet = {{"the volume is off", {"volume leaves 3 %", "bending is no better"}}};
    return choice;
  }

  TemporaryFolder m_folder;
  std::optional<std::string> m_before;
};

TEST_F(KeptEffects, AreThoseThatWereFound) {
  Scene scene = two_balls_near_a_bone();
  const auto file = kept_effects_file(scene, "text");
  ASSERT_TRUE(file);
  EXPECT_FALSE(add_kept_effects(*file, scene));
  Scene found = two_balls_near_a_bone();
  const EffectChoice choice = added_to(found);
  keep_effects(*file, found, choice);
  const auto kept = add_kept_effects(*file, scene);
  ASSERT_TRUE(kept);
  ASSERT_EQ(scene.effects.size(), found.effects.size());
  for (std::size_t i = 0; i < found.effects.size(); ++i) {
    EXPECT_EQ(scene.effects[i].name, found.effects[i].name);
    const Parameters& parameters = scene.effects[i].parameters;
    EXPECT_EQ(parameters.values(), found.effects[i].parameters.values());
    for (const auto& [key, value] : parameters.values()) {
      EXPECT_EQ(parameters.given(key), found.effects[i].parameters.given(key)) << key;
    }
  }
  ASSERT_EQ(scene.muscle_pairs.size(), 1U);
  EXPECT_EQ(scene.muscle_pairs[0].muscles, (MusclePair{0, 1}));
  ASSERT_EQ(kept->added.size(), 2U);
  EXPECT_EQ(kept->added[0].reason, "it was deep");
  ASSERT_EQ(kept->unmet.size(), 1U);
  EXPECT_EQ(kept->unmet[0].text(), choice.unmet[0].text());
  EXPECT_TRUE(kept->judged_all_frames);
}

TEST_F(KeptEffects, OfManyTheOldestGo) {
  Scene found = two_balls_near_a_bone();
  const EffectChoice choice = added_to(found);
  const fs::path folder = m_folder.path() / "many";
  fs::create_directories(folder);
  const auto start = fs::file_time_type::clock::now() - std::chrono::hours(1);
  for (int i = 0; i < 1001; ++i) {
    const fs::path file = folder / (std::to_string(i) + ".json");
    std::ofstream(file) << "{}";
    fs::last_write_time(file, start + std::chrono::seconds(i));
  }
  keep_effects(folder / "new.json", found, choice);
  EXPECT_FALSE(fs::exists(folder / "0.json") || fs::exists(folder / "1.json"));
  EXPECT_TRUE(fs::exists(folder / "2.json") && fs::exists(folder / "new.json"));
}

TEST_F(KeptEffects, AreOfOneSceneAndWhatItKeepsOut) {
  const std::map<std::string, std::function<void(Scene&)>> changes = {
      {"as it is", [](Scene&) {}},
      {"mesh", [](Scene& s) { s.bone_meshes[0].sha256 = "another"; }},
      {"kept out",
       [](Scene& s) {
         s.exclusions.push_back({"bending", false});
       }},
      {"no contact", [](Scene& s) { s.auto_effects.keeps_out_muscle_contact = true; }},
  };
  std::set<fs::path> files = {*kept_effects_file(two_balls_near_a_bone(), "another text")};
  for (const auto& [what, change] : changes) {
    Scene scene = two_balls_near_a_bone();
    change(scene);
    EXPECT_TRUE(files.insert(*kept_effects_file(scene, "text")).second) << what;
  }
}

TEST_F(KeptEffects, ThatCanNotBeUsedLeaveTheSceneAsItWas) {
  const fs::path file = m_folder.path() / "kept.json";
  for (const char* text :
       {"", "{\"added\": [", "[]", "{\"added\": []}",
        R"({"added": [{"effect": "gone", "rule": "", "reason": "", "values": []}], "unmet": []})",
        R"({"added": [{"effect": "bending", "rule": "", "reason": "", "values": ["x=1"]}], "unmet": []})",
        R"({"added": [{"effect": "bending", "rule": "", "reason": "", "values": []}], "unmet": 1})"}) {
    std::ofstream(file) << text;
    Scene scene = two_balls_near_a_bone();
    const std::size_t effects = scene.effects.size();
    EXPECT_FALSE(add_kept_effects(file, scene)) << text;
    EXPECT_EQ(scene.effects.size(), effects) << text;
    EXPECT_TRUE(scene.auto_effects.added.empty()) << text;
  }
  Scene scene = two_balls_near_a_bone();
  EXPECT_FALSE(add_kept_effects(m_folder.path(), scene)) << "a folder";
}

TEST_F(KeptEffects, ThatCanNotBeWrittenAreNone) {
  std::ofstream(m_folder.path() / "musclebench") << "a file where a folder should be";
  Scene scene = two_balls_near_a_bone();
  const auto file = kept_effects_file(scene, "text");
  keep_effects(*file, scene, added_to(scene));
  EXPECT_FALSE(fs::exists(*file));
}

}  // namespace
}  // namespace musclebench

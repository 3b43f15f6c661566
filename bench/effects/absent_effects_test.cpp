// An effect that a scene does not name costs nothing: the scene that names all others runs in a program that has the
// effect as it does in one that is built without it. Bits, heap memory and columns are the same, instructions within a
// thousandth, and not one is of the effect.
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "bench/effects/counted_program.hpp"
#include "core/effects/effect_registry.hpp"

namespace musclebench {
namespace {

std::string program_with_all() { return fmt::format("{}/effect_frames", EFFECT_PROGRAMS); }
std::string program_without(const std::string& effect) {
  return fmt::format("{}/effect_frames_without_{}", EFFECT_PROGRAMS, effect);
}

std::vector<std::string> names_of_effects() {
  std::vector<std::string> names;
  for (const EffectEntry& entry : effect_registry()) names.push_back(entry.name);
  return names;
}

std::string others(const std::string& effect) {
  std::vector<std::string> names = names_of_effects();
  std::erase(names, effect);
  return fmt::format("{}", fmt::join(names, " "));
}

/// Whether the function that tells of the effect is in the program. Debug information names more than that.
bool has_code_of(const std::string& program, const std::string& effect) {
  const Answer symbols = call("nm --defined-only " + program);
  EXPECT_EQ(symbols.exit_code, 0) << symbols.text;
  const std::string entry = effect + "_entry";
  return symbols.text.find(fmt::format("{}{}E", entry.size(), entry)) != std::string::npos;  // mangled by length
}

class AbsentEffect : public testing::TestWithParam<std::string> {};

TEST_P(AbsentEffect, CostsNeitherBitsNorMemoryNorColumns) {
  const Answer with = call(program_with_all() + " " + others(GetParam()));
  const Answer without = call(program_without(GetParam()) + " " + others(GetParam()));
  ASSERT_EQ(with.exit_code, 0) << with.text;
  ASSERT_EQ(without.exit_code, 0) << without.text;
  for (const char* key : {"state", "allocations", "bytes", "columns"}) {
    EXPECT_FALSE(with.of(key).empty()) << key;
    EXPECT_EQ(with.of(key), without.of(key)) << key;
  }
  const std::string columns = fmt::format(" {} ", with.of("columns"));
  EXPECT_EQ(columns.find(fmt::format(" {} ", GetParam())), std::string::npos) << columns;
}

TEST_P(AbsentEffect, IsNotInTheProgramThatIsBuiltWithoutIt) {
  const Answer refused = call(program_without(GetParam()) + " " + GetParam());
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.text.find(GetParam()), std::string::npos) << refused.text;
  EXPECT_EQ(call(program_with_all() + " " + GetParam()).exit_code, 0);
  EXPECT_TRUE(has_code_of(program_with_all(), GetParam()));
  // local_volume takes the parameters of volume over, and with them its file is linked.
  EXPECT_EQ(has_code_of(program_without(GetParam()), GetParam()), GetParam() == "volume");
}

class InstructionsOfAbsentEffect : public AbsentEffect {};

TEST_P(InstructionsOfAbsentEffect, AreNone) {
  if (const std::string why = why_not_counted(); !why.empty()) GTEST_SKIP() << why;
  const Counted with = count_instructions(program_with_all() + " " + others(GetParam()), GetParam());
  const Counted without = count_instructions(program_without(GetParam()) + " " + others(GetParam()), GetParam());
  EXPECT_NEAR(with.instructions / without.instructions, 1, 1e-3);
  EXPECT_FALSE(with.calls_effect);
}

INSTANTIATE_TEST_SUITE_P(Each, AbsentEffect, testing::ValuesIn(names_of_effects()),
                         [](const auto& effect) { return effect.param; });

/// One of each kind: a force, a constraint, one on contacts, one of many bones.
std::vector<std::string> few_effects() { return {"gravity", "volume", "friction", "multi_bone"}; }

/// Half a minute: once a week.
std::vector<std::string> other_effects() {
  std::vector<std::string> names = names_of_effects();
  for (const std::string& name : few_effects()) std::erase(names, name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Few, InstructionsOfAbsentEffect, testing::ValuesIn(few_effects()),
                         [](const auto& effect) { return effect.param; });
INSTANTIATE_TEST_SUITE_P(DISABLED_Others, InstructionsOfAbsentEffect, testing::ValuesIn(other_effects()),
                         [](const auto& effect) { return effect.param; });

/// What acts without a row of the registry: as soon as a scene has bones, fibres or muscles that touch.
class AbsentByScene : public testing::TestWithParam<std::string> {
 protected:
  /// All effects that a scene can have without it.
  [[nodiscard]] std::string scene() const {
    std::vector<std::string> names;
    for (const EffectEntry& entry : effect_registry()) {
      const bool calls_for_it = GetParam() == "contact"
                                    ? entry.needs_normals
                                    : GetParam() == "fibre_anisotropy" && entry.name == "activation";
      if (!calls_for_it) names.push_back(entry.name);
    }
    return fmt::format(" {}", fmt::join(names, " "));
  }
  [[nodiscard]] std::string scene_without() const { return fmt::format(" --without={}{}", GetParam(), scene()); }
};

TEST_P(AbsentByScene, CostsNeitherBitsNorMemoryNorColumns) {
  const Answer with = call(program_with_all() + scene_without());
  const Answer without = call(program_without(GetParam()) + scene_without());
  ASSERT_EQ(with.exit_code, 0) << with.text;
  ASSERT_EQ(without.exit_code, 0) << without.text;
  for (const char* key : {"state", "allocations", "bytes", "columns"}) {
    EXPECT_FALSE(with.of(key).empty()) << key;
    EXPECT_EQ(with.of(key), without.of(key)) << key;
  }
  EXPECT_NE(with.of("state"), call(program_with_all() + scene()).of("state")) << "the scene does not show it";
}

TEST_P(AbsentByScene, CostsNoInstructions) {
  if (const std::string why = why_not_counted(); !why.empty()) GTEST_SKIP() << why;
  const double with = count_instructions(program_with_all() + scene_without()).instructions;
  const double without = count_instructions(program_without(GetParam()) + scene_without()).instructions;
  EXPECT_NEAR(with / without, 1, 1e-3);
}

TEST_P(AbsentByScene, IsNotInTheProgramThatIsBuiltWithoutIt) {
  const std::string program = program_without(GetParam());
  if (GetParam() == "contact") {
    EXPECT_EQ(call(program + scene()).of("state"), call(program + scene_without()).of("state"));
  } else {
    EXPECT_NE(call(program + scene()).exit_code, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Each, AbsentByScene, testing::Values("contact", "fibre_anisotropy", "muscle_contact"),
                         [](const auto& effect) { return effect.param; });

/// The figures that are compared tell an effect that is there.
TEST(PresentEffect, IsSeenInAllFigures) {
  for (const std::string& name : {std::string("volume"), std::string("friction")}) {
    const Answer one = call(program_with_all() + " gravity edge_length " + name);
    const Answer less = call(program_with_all() + " gravity edge_length");
    for (const char* key : {"state", "allocations", "bytes", "columns"}) {
      EXPECT_NE(one.of(key), less.of(key)) << name << " " << key;
    }
  }
  if (const std::string why = why_not_counted(); !why.empty()) GTEST_SKIP() << why;
  const Counted with = count_instructions(program_with_all() + " gravity", "gravity");
  const Counted without = count_instructions(program_with_all(), "gravity");
  EXPECT_TRUE(with.calls_effect);
  EXPECT_FALSE(without.calls_effect);
  EXPECT_GT(with.instructions, 1.001 * without.instructions);
}

/// Of one frame from rest: later one effect changes how much another has to do.
void expect_cost_of_its_parts(const std::vector<std::string>& effects) {
  const std::string program = program_with_all() + " --one-frame ";
  const double none = count_instructions(program).instructions;
  double sum = 0;
  for (const std::string& name : effects) sum += count_instructions(program + name).instructions - none;
  const std::string all = fmt::format("{}", fmt::join(effects, " "));
  EXPECT_GT(sum, 0.1 * none);
  EXPECT_NEAR((count_instructions(program + all).instructions - none) / sum, 1, 0.1);
}

TEST(CostOfACombination, OfConstraintsAndContactsIsTheSumOfItsParts) {
  if (const std::string why = why_not_counted(); !why.empty()) GTEST_SKIP() << why;
  expect_cost_of_its_parts({"bending", "local_volume", "friction", "surface_contact"});
}

/// Half a minute: once a week.
TEST(CostOfACombination, DISABLED_OfAllEffectsIsTheSumOfItsParts) {
  if (const std::string why = why_not_counted(); !why.empty()) GTEST_SKIP() << why;
  expect_cost_of_its_parts(names_of_effects());
}

/// Every 41st of them; the program without arguments runs all.
TEST(Combinations, StayFinite) {
  const Answer some = call(fmt::format("{}/effect_combinations --every 41", EFFECT_PROGRAMS));
  EXPECT_EQ(some.exit_code, 0) << some.text;
  EXPECT_NE(some.text.find("all stay finite"), std::string::npos) << some.text;
}

}  // namespace
}  // namespace musclebench

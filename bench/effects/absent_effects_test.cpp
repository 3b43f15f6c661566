// An effect that a scene does not name costs nothing: the scene that names all others runs in a program that has the
// effect as it does in one that is built without it. Bits, heap memory and columns are the same, instructions within a
// thousandth, and not one is of the effect.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "core/effects/effect_registry.hpp"

namespace musclebench {
namespace {

namespace fs = std::filesystem;

struct Answer {
  int exit_code = 0;
  std::string text;

  /// What the line says that begins with the key.
  [[nodiscard]] std::string of(const std::string& key) const {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with(key + " ")) return line.substr(key.size() + 1);
    }
    return "";
  }
};

Answer call(const std::string& command) {
  Answer answer;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");  // NOLINT(cert-env33-c): paths of the build
  std::array<char, 4096> buffer{};
  for (std::size_t count = 0; (count = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    answer.text.append(buffer.data(), count);
  }
  answer.exit_code = WEXITSTATUS(pclose(pipe));
  return answer;
}

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

/// Whether the symbol of the function that makes the effect is in the program.
bool has_code_of(const std::string& program, const std::string& effect) {
  std::ifstream stream(program, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  const auto has = [&](const std::string& function) {
    return bytes.find(fmt::format("{}{}E", function.size(), function)) != std::string::npos;  // mangled by length
  };
  return has("make_" + effect) || has("set_" + effect);
}

bool has_valgrind() { return call("command -v valgrind").exit_code == 0; }

/// What callgrind counts in the function that makes and runs the simulation.
struct Counted {
  double instructions = 0;
  bool calls_effect = false;  ///< whether a function that makes the effect ran
};

Counted count_instructions(const std::string& program, const std::string& effects, const std::string& effect) {
  const fs::path file = fs::temp_directory_path() /
                        fmt::format("absent_effects_{}_{}.out", getpid(), fs::path(program).filename().string());
  const Answer answer =
      call(fmt::format("valgrind --tool=callgrind --callgrind-out-file='{}' --collect-atstart=no "
                       "--toggle-collect='*counted_run*' '{}' {}",
                       file.string(), program, effects));
  EXPECT_EQ(answer.exit_code, 0) << answer.text;
  std::ifstream stream(file);
  Counted counted;
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("summary: ") || line.starts_with("totals: ")) {
      counted.instructions = std::strtod(line.c_str() + line.find(' '), nullptr);
    }
    counted.calls_effect |= line.find(fmt::format("::make_{}(", effect)) != std::string::npos ||
                            line.find(fmt::format("::set_{}(", effect)) != std::string::npos;
  }
  fs::remove(file);
  EXPECT_GT(counted.instructions, 1e6) << answer.text;
  return counted;
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

TEST_P(AbsentEffect, CostsNoInstruction) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "valgrind does not run what is built with a sanitizer";
#endif
  if (!has_valgrind()) GTEST_SKIP() << "valgrind is missing; tools/setup --all installs it";
  const Counted with = count_instructions(program_with_all(), others(GetParam()), GetParam());
  const Counted without = count_instructions(program_without(GetParam()), others(GetParam()), GetParam());
  EXPECT_NEAR(with.instructions / without.instructions, 1, 1e-3);
  EXPECT_FALSE(with.calls_effect);
}

INSTANTIATE_TEST_SUITE_P(Each, AbsentEffect, testing::ValuesIn(names_of_effects()),
                         [](const auto& effect) { return effect.param; });

/// The figures that are compared tell an effect that is there.
TEST(PresentEffect, IsSeenInAllFigures) {
  const Answer none = call(program_with_all());
  for (const std::string& name : {std::string("volume"), std::string("friction")}) {
    const Answer one = call(program_with_all() + " gravity edge_length " + name);
    const Answer less = call(program_with_all() + " gravity edge_length");
    for (const char* key : {"state", "allocations", "bytes", "columns"}) {
      EXPECT_NE(one.of(key), less.of(key)) << name << " " << key;
    }
  }
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  if (!has_valgrind()) GTEST_SKIP() << "valgrind is missing; tools/setup --all installs it";
  const Counted with = count_instructions(program_with_all(), "gravity", "gravity");
  const Counted without = count_instructions(program_with_all(), "", "gravity");
  EXPECT_TRUE(with.calls_effect);
  EXPECT_FALSE(without.calls_effect);
  EXPECT_GT(with.instructions, 1.001 * without.instructions);
#endif
}

}  // namespace
}  // namespace musclebench

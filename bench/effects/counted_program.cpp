#include "bench/effects/counted_program.hpp"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <sys/wait.h>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/temporary_folder.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MUSCLEBENCH_SANITIZED_TEST
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define MUSCLEBENCH_SANITIZED_TEST
#endif
#endif

namespace musclebench {

std::string Answer::of(const std::string& key) const {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(key + " ")) return line.substr(key.size() + 1);
  }
  return "";
}

Answer call(const std::string& command) {
  Answer answer;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");  // NOLINT(cert-env33-c): programs of this build
  std::array<char, 4096> buffer{};
  for (std::size_t count = 0; (count = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    answer.text.append(buffer.data(), count);
  }
  answer.exit_code = WEXITSTATUS(pclose(pipe));
  return answer;
}

std::string why_not_counted() {
#ifdef MUSCLEBENCH_SANITIZED_TEST
  return "valgrind does not run what is built with a sanitizer";
#else
  if (call("command -v valgrind").exit_code != 0) return "valgrind is missing; tools/setup --all installs it";
  // Highway reads the clock as it is loaded, and valgrind knows that instruction only where the processor has it.
  const bool can_run = call("test $(uname -m) != x86_64 || grep -qw rdtscp /proc/cpuinfo").exit_code == 0;
  return can_run ? "" : "valgrind cannot run the program on a processor without rdtscp; take another machine";
#endif
}

Counted count_instructions(const std::string& command, const std::string& effect) {
  const TemporaryFolder folder;
  const auto file = folder / "instructions";
  const Answer answer =
      call(fmt::format("valgrind --tool=callgrind --callgrind-out-file='{}' --collect-atstart=no "
                       "--toggle-collect='*counted_run*' {}",
                       file.string(), command));
  EXPECT_EQ(answer.exit_code, 0) << answer.text;
  std::ifstream stream(file);
  Counted counted;
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("summary: ") || line.starts_with("totals: ")) {
      counted.instructions = std::strtod(line.c_str() + line.find(' '), nullptr);
    }
    counted.calls_effect |= !effect.empty() && (line.find(fmt::format("::make_{}(", effect)) != std::string::npos ||
                                                line.find(fmt::format("::set_{}(", effect)) != std::string::npos);
  }
  EXPECT_GT(counted.instructions, 1e5) << answer.text;
  return counted;
}

}  // namespace musclebench

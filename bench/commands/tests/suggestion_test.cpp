#include "bench/commands/suggestion.hpp"

#include <vector>

#include <CLI/CLI.hpp>
#include <gtest/gtest.h>

namespace musclebench {
namespace {

std::string suggested(const std::vector<const char*>& arguments) {
  CLI::App app("test");
  int number = 0;
  CLI::App* command = app.add_subcommand("replay");
  command->add_option("--backend", number);
  command->add_option("--threads", number);
  app.add_subcommand("record")->add_option("--frames", number);
  return suggestion(app, arguments).value_or("");
}

TEST(Suggestion, IsTheNearestCommand) {
  EXPECT_EQ(suggested({"reply"}), "'reply' is no command; did you mean 'replay'?");
  EXPECT_EQ(suggested({"recrod", "--frames", "3"}), "'recrod' is no command; did you mean 'record'?");
}

TEST(Suggestion, IsTheNearestOptionOfTheCommand) {
  EXPECT_EQ(suggested({"replay", "a", "--bakend=x"}), "'--bakend' is no option of `replay`; did you mean '--backend'?");
  EXPECT_EQ(suggested({"replay", "--frames", "3"}), "'--frames' is no option of `replay`; did you mean '--threads'?");
}

TEST(Suggestion, IsNoneWhereTheWordsAreKnown) {
  EXPECT_EQ(suggested({}), "");
  EXPECT_EQ(suggested({"--verbose"}), "");
  EXPECT_EQ(suggested({"replay", "--threads", "-1", "--", "-x"}), "");
}

}  // namespace
}  // namespace musclebench

#include "bench/commands/command_line.hpp"

#include <exception>
#include <filesystem>
#include <new>
#include <span>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/commands/commands.hpp"
#include "bench/commands/suggestion.hpp"
#include "bench/results/build_info.hpp"
#include "core/base/input_error.hpp"
#include "core/base/unsupported_input.hpp"

namespace musclebench {

int run_command_line(int argc, const char* const* argv) {
  CLI::App app(
      "musclebench measures what collision accuracy costs in a muscle simulation.\n"
      "A position-based-dynamics loop moves muscles against rigid bones. You choose the backend, which is the method "
      "that detects collisions. The program measures its time, its memory and the true penetration depth.");
  app.footer(
      "Examples:\n"
      "  musclebench list\n"
      "  musclebench run synthetic/iliacus --backend sdf --param cells=128\n"
      "  musclebench advise synthetic/iliacus --depth-mm 0.5\n"
      "`musclebench COMMAND --help` shows the options of a command. Results go into reports/out unless --out names a "
      "folder.");
  app.require_subcommand(1);
  const BuildInfo build = build_info();
  app.set_version_flag(
      "--version", fmt::format("musclebench {} ({}, {}, {})", build.version, build.git, build.compiler, build.type));
  int exit_code = 0;
  add_run_command(app, exit_code);
  add_record_command(app, exit_code);
  add_replay_command(app, exit_code);
  add_queries_command(app, exit_code);
  add_list_command(app, exit_code);
  add_check_command(app, exit_code);
  add_verify_command(app, exit_code);
  add_probe_command(app, exit_code);
  add_advise_command(app, exit_code);
  add_field_command(app, exit_code);
  add_hard_command(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      return app.exit(error);
    }
    const auto nearest = suggestion(app, std::span(argv, static_cast<std::size_t>(argc)).subspan(argc > 0 ? 1 : 0));
    fmt::print(stderr, "musclebench: {}; --help shows the options\n",
               InputError("command line", nearest.value_or(error.what())).what());
    return exit_bad_input;
  } catch (const UnsupportedInput& error) {
    fmt::print(stderr, "musclebench: {}\n", error.what());
    return exit_unsupported;
  } catch (const InputError& error) {
    fmt::print(stderr, "musclebench: {}\n", error.what());
    return exit_bad_input;
  } catch (const std::filesystem::filesystem_error& error) {
    fmt::print(stderr, "musclebench: {}\n", InputError("files", error.what()).what());
    return exit_bad_input;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "musclebench: this run needs more memory than there is; choose fewer cells or frames\n");
    return exit_bad_input;
  } catch (const std::exception& error) {
    fmt::print(stderr, "musclebench: unexpected failure: {}\n", error.what());
    return exit_unexpected;
  }
  return exit_code;
}

}  // namespace musclebench

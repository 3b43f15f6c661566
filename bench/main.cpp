#include <csignal>
#include <filesystem>
#include <new>
#include <span>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/commands/commands.hpp"
#include "bench/commands/suggestion.hpp"
#include "bench/results/build_info.hpp"
#include "core/base/input_error.hpp"

namespace {

/// Meshes are read, repaired and dropped one after the other. Memory that is given back in between comes as new pages
/// again, which costs a tenth of a run's set-up. A run gives it back once, before its first frame.
void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int never = 1 << 30;
  (void)mallopt(M_MMAP_THRESHOLD, never);
  (void)mallopt(M_TRIM_THRESHOLD, never);
  (void)mallopt(M_TOP_PAD, 32 << 20);
#endif
}

}  // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): it escapes only where the complaint itself cannot be printed.
int main(int argc, char** argv) {
  using namespace musclebench;
  keep_freed_memory();
  // A file that outgrows the limit (ulimit -f) is a failed write with its line, not the end at once.
  std::signal(SIGXFSZ, SIG_IGN);
  CLI::App app(
      "musclebench: what does collision accuracy cost in a muscle simulation?\n"
      "One position-based-dynamics loop moves a muscle against rigid bones; one collision backend is plugged in and "
      "measured for time, memory and true penetration depth.");
  app.require_subcommand(1);
  const BuildInfo build = build_info();
  app.set_version_flag(
      "--version", fmt::format("musclebench {} ({}, {}, {})", build.version, build.git, build.compiler, build.type));
  int exit_code = 0;
  add_run_command(app, exit_code);
  add_record_command(app, exit_code);
  add_replay_command(app, exit_code);
  add_list_command(app, exit_code);
  add_check_command(app, exit_code);
  add_verify_command(app, exit_code);
  add_probe_command(app, exit_code);
  add_advise_command(app, exit_code);
  add_field_command(app, exit_code);
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
  } catch (const InputError& error) {
    fmt::print(stderr, "musclebench: {}\n", error.what());
    return exit_bad_input;
  } catch (const std::filesystem::filesystem_error& error) {
    fmt::print(stderr, "musclebench: {}\n", InputError("files", error.what()).what());
    return exit_bad_input;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "musclebench: there is not enough memory for this run; choose fewer cells or frames\n");
    return exit_bad_input;
  } catch (const std::exception& error) {
    fmt::print(stderr, "musclebench: unexpected failure: {}\n", error.what());
    return exit_unexpected;
  }
  return exit_code;
}

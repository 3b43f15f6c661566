#include <memory>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/commands/command_options.hpp"
#include "bench/commands/commands.hpp"
#include "bench/process/progress.hpp"
#include "bench/process/signals.hpp"
#include "bench/results/other_case.hpp"
#include "bench/results/probe_output.hpp"
#include "bench/results/result_folder.hpp"
#include "bench/results/summary.hpp"

namespace musclebench {

namespace {

struct ProbeOptions {
  SceneOptions scene;
  BackendOptions backend;
  std::string out;
  int points = 20000;
  std::uint64_t seed = 1;
  double band_mm = 2;
  bool progress_lines = false;
  bool force = false;
};

ProbeResult probe_and_write(const ProbeCase& what, const ProbeOptions& options, const std::string& out) {
  std::optional<EndAtOnce> until_written(std::in_place);
  ProbeResult result;
  {
    const int total = what.points * static_cast<int>(what.scene.bones.size());
    Progress progress(progress_style(options.progress_lines), fmt::format("{} {}", what.scene.name, what.backend.name),
                      total);
    result = probe(what, [&](int done) { progress.show(done); });
  }
  const HeldSignals held;
  write_probe(out, what, result);
  until_written.reset();
  return result;
}

int run_probe(const ProbeOptions& options) {
  const BackendEntry& backend = find_backend(options.backend.backend);
  const Parameters parameters = backend_parameters(backend, options.backend.parameters);
  const Scene scene = load_scene(options.scene);
  const ProbeCase what{
      {scene, backend, parameters, options.backend.threads, 0}, options.points, options.seed, options.band_mm * 1e-3};
  const std::string id = probe_id(what);
  const std::string out = options.out.empty() ? fmt::format("reports/out/probes/raw/{}", id) : options.out;
  if (!options.force && is_complete(out, id, "probe.csv")) {
    fmt::print("{} with {}: complete already in {} (--force runs it again)\n", scene.name, backend.name, out);
    return 0;
  }
  if (!options.force) {
    require_no_other_case(out, what, "probe");
  }
  {
    const HeldSignals held;
    require_writable(out);
  }
  const ProbeResult result = probe_and_write(what, options, out);
  if (result.status != "ok") {
    fmt::print(stderr, "musclebench: {}: {}: {}\n", scene.name, result.status, result.status_detail);
    return exit_diverged;
  }
  fmt::print("{}  written to {}\n", probe_summary(what, result), out);
  return 0;
}

}  // namespace

void add_probe_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ProbeOptions>();
  CLI::App* command = app.add_subcommand("probe", "Measure a backend's depth error at random points near each bone");
  command->footer(
      "Example: musclebench probe synthetic/iliacus --backend sdf --param cells=128\n"
      "Results: run.json and probe.csv in the folder of --out.");
  add_scene_options(*command, options->scene);
  add_backend_options(*command, options->backend);
  command->add_option("--points", options->points, "Number of points around each bone")
      ->capture_default_str()
      ->check(CLI::Range(1, 10'000'000));
  command->add_option("--seed", options->seed, "Random seed of the points")->capture_default_str();
  command->add_option("--band-mm", options->band_mm, "Largest distance of a point from the surface, mm")
      ->capture_default_str()
      ->check(positive_and_finite());
  command->add_option("--out", options->out, "Result folder (default: reports/out/probes/raw/<run id>)");
  command->add_flag("--progress", options->progress_lines, "Print 'progress DONE TOTAL' lines on standard error");
  command->add_flag("--force", options->force, "Run again even if the result is complete");
  command->callback([options, &exit_code] { exit_code = run_probe(*options); });
}

}  // namespace musclebench

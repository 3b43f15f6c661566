#include <algorithm>
#include <csignal>
#include <numeric>
#include <thread>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/commands.hpp"
#include "bench/progress.hpp"
#include "bench/run_output.hpp"
#include "bench/scene_source.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

struct RunOptions {
  SceneChoice choice;
  std::string backend;
  std::vector<std::string> parameters;
  std::vector<std::string> loop;
  std::string out;
  int threads = 1;
  int frames = 0;
  int repetition = 0;
  std::vector<int> snapshots;
  bool progress_lines = false;
  bool unjudged = false;
  bool force = false;
};

std::map<std::string, ParameterValue> parse_assignments(const std::vector<std::string>& texts,
                                                        const std::string& option) {
  std::map<std::string, ParameterValue> values;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw InputError(fmt::format("{} {}", option, text), "has to read key=value");
    }
    values[text.substr(0, equals)] = parse_parameter_value(std::string_view(text).substr(equals + 1));
  }
  return values;
}

std::string median_ms(const std::vector<StepRecord>& records, Nanoseconds (*figure)(const StepRecord&)) {
  std::vector<double> values;
  for (const StepRecord& record : records) {
    if (!record.warm_up) {
      values.push_back(static_cast<double>(figure(record)) * 1e-6);
    }
  }
  if (values.empty()) {
    return "unknown (warm-up only)";
  }
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return fmt::format("{:10.3f} ms", values[values.size() / 2]);
}

void print_summary(const RunCase& run, const RunResult& result, const std::string& out) {
  const std::string collision_ms = median_ms(
      result.records, [](const StepRecord& r) { return r.times.update_ns + r.times.detect_ns + r.times.respond_ns; });
  const std::string frame_ms = median_ms(result.records, [](const StepRecord& r) { return r.times.frame_ns; });
  double deepest_m = 0;
  for (const StepRecord& record : result.records) {
    deepest_m = std::max(deepest_m, record.depth.max_depth_m);
  }
  fmt::print("{} with {}: {}{}{}\n", run.scene.name, run.backend.name, result.status,
             result.status_detail.empty() ? "" : ", ", result.status_detail);
  for (const Attachment& attachment : run.scene.attachments) {
    fmt::print("  attachment {:<18} {:>6} nodes on {}\n", attachment.name, attachment.nodes.size(),
               run.scene.bones[attachment.bone].name);
  }
  if (run.scene.attach_at_first_contact) {
    fmt::print("  bound at first contact        {:>6} nodes\n", result.bound_nodes.size());
  }
  fmt::print("  frames                        {:>6}\n", result.records.size());
  fmt::print("  frame, median                 {}\n", frame_ms);
  fmt::print("  of it collision               {}\n", collision_ms);
  fmt::print("  structures                    {:>10.3f} MB, built in {:.2f} s\n",
             static_cast<double>(result.structure_bytes) * 1e-6, static_cast<double>(result.build_ns) * 1e-9);
  if (run.judge) {
    fmt::print("  largest true depth            {:>10.3f} mm\n", deepest_m * 1e3);
  }
  fmt::print("  state hash                    {}\n  written to {}\n", result.state_hash, out);
}

Progress::Style progress_style(const RunOptions& options) {
  if (options.progress_lines) {
    return Progress::Style::lines;
  }
  return isatty(STDERR_FILENO) != 0 ? Progress::Style::bar : Progress::Style::none;
}

/// Nothing of a run is on the disk before it is written, so until then the process may end at once.
void end_at_once(int /*signal*/) {
  static constexpr char message[] = "\nmusclebench: interrupted; nothing was written\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, message, sizeof message - 1);
  _exit(exit_interrupted);
}

/// Holds back Ctrl-C and termination while files are being moved.
class HeldSignals {
 public:
  HeldSignals() {
    sigset_t held;
    sigemptyset(&held);
    sigaddset(&held, SIGINT);
    sigaddset(&held, SIGTERM);
    sigprocmask(SIG_BLOCK, &held, &m_before);
  }
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;
  ~HeldSignals() { sigprocmask(SIG_SETMASK, &m_before, nullptr); }

 private:
  sigset_t m_before{};
};

int run(RunOptions options) {
  if (options.frames > 0) {
    options.choice.loop_overrides["frames"] = std::int64_t{options.frames};
  }
  for (const auto& [key, value] : parse_assignments(options.loop, "--loop")) {
    options.choice.loop_overrides[key] = value;
  }
  const BackendEntry& backend = find_backend(options.backend);
  const Parameters parameters(backend.parameters, parse_assignments(options.parameters, "--param"),
                              fmt::format("--param ({})", backend.name));
  const Scene scene = load_scene(options.choice);
  for (const std::string& warning : scene_warnings(scene)) {
    fmt::print(stderr, "musclebench: warning: {}: {}\n", scene.name, warning);
  }
  std::sort(options.snapshots.begin(), options.snapshots.end());
  const RunCase run_of{scene, backend,           parameters,       options.threads, options.repetition,
                       2,     !options.unjudged, options.snapshots};
  const std::string id = run_id(run_of);
  const std::string out = options.out.empty() ? fmt::format("reports/out/runs/raw/{}", id) : options.out;
  if (!options.force && is_complete(out, id)) {
    fmt::print("{} with {}: complete already in {} (--force runs it again)\n", scene.name, backend.name, out);
    return 0;
  }
  {
    const HeldSignals held;
    require_writable(out);
  }
  if (!options.snapshots.empty() && options.snapshots.back() > scene.loop.frames) {
    fmt::print(stderr, "musclebench: warning: --snapshots: frame {} is not among the {} frames of the run\n",
               options.snapshots.back(), scene.loop.frames);
  }

  std::signal(SIGINT, end_at_once);
  std::signal(SIGTERM, end_at_once);
  RunResult result;
  {
    Progress progress(progress_style(options), fmt::format("{} {}", scene.name, backend.name), scene.loop.frames);
    result = run_case(run_of, [&](int done) { progress.show(done); });
  }
  {
    const HeldSignals held;
    write_run(out, run_of, result);
    std::signal(SIGINT, SIG_DFL);
    std::signal(SIGTERM, SIG_DFL);
  }
  print_summary(run_of, result, out);
  if (result.status == "diverged") {
    fmt::print(stderr, "musclebench: {}: diverged: {}\n", scene.name, result.status_detail);
    return exit_diverged;
  }
  return 0;
}

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = app.add_subcommand("run", "Run one case and write run.json and frames.csv");
  command->add_option("scene", options->choice.scene, "Name of an embedded scene or path of a .toml file")->required();
  command->add_option("--backend", options->backend, "Collision backend (see `musclebench list`)")->required();
  command->add_option("--param", options->parameters, "Parameter of the backend, key=value; may be repeated");
  command->add_option("--preset", options->choice.preset, "Loop and effects: paper or standard (default: the scene's)");
  command->add_option("--loop", options->loop, "Parameter of the loop, key=value, over scene and preset");
  command->add_option("--data", options->choice.data, "Folder of the anatomical data (default: $MUSCLEBENCH_DATA)");
  command->add_option("--out", options->out, "Result folder (default: reports/out/runs/raw/<run id>)");
  command->add_option("--frames", options->frames, "Frames of the whole motion (default: the preset's)")
      ->check(CLI::Range(1, 10000000));
  command->add_option("--threads", options->threads, "Threads of the backend (default: 1)")->check(CLI::Range(1, 4096));
  command->add_option("--repetition", options->repetition, "Number of the repetition, a part of the run's identity")
      ->check(CLI::Range(0, 1000000));
  command->add_option("--snapshots", options->snapshots, "Frames whose shape is kept, such as 0,79,157")
      ->delimiter(',')
      ->check(CLI::Range(0, 10000000));
  command->add_flag("--progress", options->progress_lines, "Print 'progress DONE TOTAL' lines on standard error");
  command->add_flag("--no-referee", options->unjudged, "Do not judge: depths, missed and false contacts stay empty");
  command->add_flag("--force", options->force, "Run even when the result is complete already");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace musclebench

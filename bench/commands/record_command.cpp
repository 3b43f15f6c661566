#include <filesystem>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/cases/build_backend.hpp"
#include "bench/cases/record_case.hpp"
#include "bench/commands/command_options.hpp"
#include "bench/commands/commands.hpp"
#include "bench/commands/effect_trials.hpp"
#include "bench/process/progress.hpp"
#include "bench/process/signals.hpp"
#include "bench/results/build_info.hpp"
#include "bench/results/manifest.hpp"
#include "bench/results/recording_header_of.hpp"
#include "core/recording/recording_writer.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

namespace {

namespace fs = std::filesystem;

struct RecordOptions {
  SceneOptions scene;
  BackendOptions backend;
  std::string out;
  bool progress_lines = false;
};

void print_summary(const RecordingHeader& header, const RecordingFile& file, Nanoseconds wall_ns,
                   const std::string& out) {
  const double positions = static_cast<double>(header.nodes) * header.steps_per_frame() * header.frames();
  fmt::print("{} recorded with {}\n", header.scene, header.backend);
  fmt::print("  frames                        {:>6} of {} steps\n", header.frames(), header.steps_per_frame());
  fmt::print("  nodes                         {:>6}, {} of them free\n", header.nodes, header.free_nodes.size());
  fmt::print("  size                          {:>6.1f} MB, {:.2f} bytes a node and step\n",
             static_cast<double>(file.bytes) * 1e-6, static_cast<double>(file.bytes) / positions);
  fmt::print("  positions rounded to          {:>6.2g} m\n", header.rounding_m);
  fmt::print("  time                          {:>6.1f} s\n", static_cast<double>(wall_ns) * 1e-9);
  fmt::print("  sha256                        {}\n  written to {}\n", file.sha256, out);
}

int record(const RecordOptions& options) {
  const BackendEntry& backend =
      options.backend.backend.empty() ? exact_backend() : find_backend(options.backend.backend);
  const Parameters parameters = backend_parameters(backend, options.backend.parameters);
  const Scene scene = load_scene(options.scene);
  require_named_effects(scene, "a recording");
  const Case resolved = resolve_case(scene, backend, parameters,
                                     {.response = options.backend.response,
                                      .colliders = options.backend.colliders,
                                      .threads = options.backend.threads});
  const fs::path out = options.out;
  {
    const HeldSignals held;
    require_recording_writable(out);
  }

  const Nanoseconds start_ns = monotonic_now_ns();
  std::optional<EndAtOnce> until_written(std::in_place);
  const BuiltBackend built = build_backend(resolved);
  const PreparedSimulation prepared =
      prepare_simulation(resolved.scene, *built.backend, resolved.responses, resolved.threads,
                         make_contact_methods(scene, resolved.colliders, resolved.threads));
  release_shared(scene);
  const RecordingHeader header =
      recording_header(resolved, choice_of(options.scene), {1, scene.loop.frames}, prepared.simulation->free_nodes());
  std::optional<RecordingWriter> writer;
  {
    const HeldSignals held;
    writer.emplace(out, header);
    until_written->remove_first(writer->part());
  }
  {
    Progress progress(progress_style(options.progress_lines), "record " + scene.name, scene.loop.frames);
    const std::string lost =
        record_frames(*prepared.simulation, scene, *writer, [&](int frames_done) { progress.show(frames_done); });
    if (!lost.empty()) {
      fmt::print(stderr, "musclebench: {}: diverged, nothing was recorded: {}\n", scene.name, lost);
      return exit_diverged;
    }
  }
  RecordingFile file;
  {
    const HeldSignals held;
    file = writer->finish();
    until_written.reset();
  }
  print_summary(header, file, monotonic_now_ns() - start_ns, options.out);
  return 0;
}

}  // namespace

void add_record_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<RecordOptions>();
  CLI::App* command = app.add_subcommand("record", "Run a scene and store the input of every collision step in a file");
  command->footer(
      "Example: musclebench record synthetic/iliacus --out iliacus.steps\n"
      "`musclebench replay` feeds the file to any backend.");
  add_scene_options(*command, options->scene);
  add_backend_options(*command, options->backend);
  add_response_option(*command, options->backend);
  add_collider_option(*command, options->backend);
  command->get_option("--backend")
      ->required(false)
      ->description("Backend that drives the run (default: an exact backend)");
  command->add_option("--out", options->out, "File to write the recording to")->required();
  command->add_flag("--progress", options->progress_lines, "Print 'progress DONE TOTAL' lines on standard error");
  command->callback([options, &exit_code] { exit_code = record(*options); });
}

}  // namespace musclebench

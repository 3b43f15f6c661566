#include <algorithm>
#include <filesystem>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bench/commands/command_options.hpp"
#include "bench/commands/commands.hpp"
#include "bench/process/progress.hpp"
#include "bench/process/signals.hpp"
#include "core/base/input_error.hpp"
#include "core/base/scoped_timer.hpp"

namespace musclebench {

namespace {

namespace fs = std::filesystem;

constexpr int progress_steps = 1000;

struct FieldOptions {
  SceneOptions scene;
  BackendOptions backend;
  std::string bone;
  std::string out;
  bool progress_lines = false;
};

const Bone& find_bone(const Scene& scene, const std::string& name) {
  const auto found = std::find_if(scene.bones.begin(), scene.bones.end(),
                                  [&](const Bone& bone) { return name.empty() || bone.name == name; });
  if (found == scene.bones.end() || (name.empty() && scene.bones.size() > 1)) {
    std::string names;
    for (const Bone& bone : scene.bones) {
      names += (names.empty() ? "" : ", ") + bone.name;
    }
    throw InputError(name.empty() ? "--bone" : "--bone " + name,
                     fmt::format("{} has the bones {}; name one of them", scene.name, names));
  }
  return *found;
}

void print_summary(const Scene& scene, const Bone& bone, const BuiltStructure& built, Nanoseconds build_ns,
                   const std::string& out) {
  fmt::print("{} of {}\n", bone.name, scene.name);
  fmt::print("  cells                         {}\n", built.cells);
  fmt::print("  size                          {:.3f} MB\n", static_cast<double>(built.bytes) * 1e-6);
  fmt::print("  built in                      {:.2f} s\n", static_cast<double>(build_ns) * 1e-9);
  fmt::print("  error near the surface        {:.4f} mm at 99 of 100 points, {:.4f} mm at most, of {} points\n",
             built.p99_error_m * 1e3, built.largest_error_m * 1e3, built.samples);
  fmt::print("  written to {}\n", out);
}

/// Builds with progress, then writes with signals held back.
int build_and_write(const FieldOptions& options, const BackendEntry& backend, const Parameters& parameters,
                    const Scene& scene, const Bone& bone) {
  std::optional<EndAtOnce> until_written(std::in_place);
  const Nanoseconds start_ns = monotonic_now_ns();
  BuiltStructure built;
  {
    Progress progress(progress_style(options.progress_lines), "field " + bone.name, progress_steps);
    built = backend.structure_export.build(bone, parameters, options.backend.threads, [&](double share) {
      progress.show(static_cast<int>(share * progress_steps));
    });
  }
  const Nanoseconds build_ns = monotonic_now_ns() - start_ns;
  const HeldSignals held;
  built.write(options.out);
  until_written.reset();
  print_summary(scene, bone, built, build_ns, options.out);
  return 0;
}

std::vector<std::string> exporting_backends() {
  std::vector<std::string> names;
  for (const BackendEntry& entry : backend_registry()) {
    if (entry.structure_export) {
      names.push_back(entry.name);
    }
  }
  return names;
}

std::string file_formats() {
  std::string formats;
  for (const BackendEntry& entry : backend_registry()) {
    if (entry.structure_export) {
      formats += (formats.empty() ? "" : "; ") + entry.structure_export.formats;
    }
  }
  return formats;
}

const BackendEntry& chosen_backend(const std::string& option) {
  const std::vector<std::string> exporting = exporting_backends();
  if (exporting.empty()) {
    throw InputError("field", "no backend of this build writes its structures to files");
  }
  const BackendEntry& backend = find_backend(option.empty() ? exporting.front() : option);
  if (!backend.structure_export) {
    throw InputError("--backend " + option, fmt::format("has no distance field; {} has", fmt::join(exporting, ", ")));
  }
  return backend;
}

int make_field(const FieldOptions& options) {
  const BackendEntry& backend = chosen_backend(options.backend.backend);
  const Parameters parameters = backend_parameters(backend, options.backend.parameters);
  backend.structure_export.require_fit(parameters, options.out);
  const Scene scene = load_scene(options.scene);
  return build_and_write(options, backend, parameters, scene, find_bone(scene, options.bone));
}

}  // namespace

void add_field_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<FieldOptions>();
  CLI::App* command = app.add_subcommand("field", "Build one bone's distance field and write it to a file");
  command->footer("Example: musclebench field synthetic/iliacus --param cells=128 --bone femur --out femur.field");
  add_scene_options(*command, options->scene);
  add_backend_options(*command, options->backend);
  command->get_option("--backend")
      ->required(false)
      ->description("Backend that builds the field (default: the first that can)");
  command->add_option("--bone", options->bone, "Name of the bone (default: the scene's only bone)");
  command->add_option("--out", options->out, "File to write: " + file_formats())->required();
  command->add_flag("--progress", options->progress_lines, "Print 'progress DONE TOTAL' lines on standard error");
  command->callback([options, &exit_code] { exit_code = make_field(*options); });
}

}  // namespace musclebench

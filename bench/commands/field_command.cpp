#include <algorithm>
#include <filesystem>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "backends/sdf/build/field_memory.hpp"
#include "backends/sdf/files/discregrid_file.hpp"
#include "backends/sdf/files/field_file.hpp"
#include "backends/sdf/files/octree_file.hpp"
#include "backends/sdf/sdf_settings.hpp"
#include "bench/commands/command_options.hpp"
#include "bench/commands/commands.hpp"
#include "bench/process/progress.hpp"
#include "bench/process/signals.hpp"
#include "core/base/input_error.hpp"
#include "core/base/scoped_timer.hpp"

namespace musclebench {

namespace {

namespace fs = std::filesystem;

constexpr const char* field_backend = "sdf";
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

/// The ending says what is written; refuses what does not fit the field before anything is built.
void require_ending(const fs::path& out, bool octree, const FieldSettings& settings) {
  const std::string ending = out.extension().string();
  const std::string wanted = octree ? ".octree" : ".cdf or .field";
  if (octree ? ending != ".octree" : (ending != ".cdf" && ending != ".field")) {
    throw InputError("--out " + out.string(), fmt::format("has to end in {} for this field", wanted));
  }
  if (ending == ".cdf" && settings.band_m) {
    throw InputError("--out " + out.string(), "Discregrid's format wants a value in every cell; leave out `band_m`");
  }
}

struct FieldSummary {
  std::string cells;
  std::size_t bytes = 0;
  double p99_m = 0;
  double largest_m = 0;
  std::int64_t samples = 0;
};

void print_summary(const Scene& scene, const Bone& bone, const FieldSummary& summary, Nanoseconds build_ns,
                   const std::string& out) {
  fmt::print("{} of {}\n", bone.name, scene.name);
  fmt::print("  cells                         {}\n", summary.cells);
  fmt::print("  size                          {:.3f} MB\n", static_cast<double>(summary.bytes) * 1e-6);
  fmt::print("  built in                      {:.2f} s\n", static_cast<double>(build_ns) * 1e-9);
  fmt::print("  error near the surface        {:.4f} mm at 99 of 100 places, {:.4f} mm at most, of {} places\n",
             summary.p99_m * 1e3, summary.largest_m * 1e3, summary.samples);
  fmt::print("  written to {}\n", out);
}

/// Builds with progress, then writes with signals held back.
template <typename Build, typename Write>
Nanoseconds build_and_write(const FieldOptions& options, const std::string& label, const Build& build,
                            const Write& write) {
  std::optional<EndAtOnce> until_written(std::in_place);
  const Nanoseconds start_ns = monotonic_now_ns();
  Nanoseconds build_ns = 0;
  {
    Progress progress(progress_style(options.progress_lines), label, progress_steps);
    build([&](double share) { progress.show(static_cast<int>(share * progress_steps)); });
    build_ns = monotonic_now_ns() - start_ns;
  }
  const HeldSignals held;
  write();
  until_written.reset();
  return build_ns;
}

int write_octree(const FieldOptions& options, const Scene& scene, const Bone& bone, const Parameters& parameters) {
  const OctreeSettings settings = octree_settings(parameters);
  std::optional<OctreeField> field;
  const Nanoseconds build_ns = build_and_write(
      options, "field " + bone.name,
      [&](const BuildProgress& progress) {
        field.emplace(build_octree(SignedSurface(bone.surface), bone.surface.mesh, settings, bone.name,
                                   options.backend.threads, progress));
      },
      [&] { save_octree(*field, surface_digest(bone.surface), settings, options.out); });
  const OctreeQuality& quality = field->quality();
  const std::string cells = fmt::format("{} of {:.3g} to {:.3g} mm", field->leaf_count(), quality.finest_edge_m * 1e3,
                                        field->shape().root_edge_m * 1e3);
  print_summary(scene, bone, {cells, field->bytes(), quality.p99_m, quality.largest_m, quality.samples}, build_ns,
                options.out);
  return 0;
}

int write_grid(const FieldOptions& options, const Scene& scene, const Bone& bone, const Parameters& parameters) {
  const FieldSettings settings = field_settings(parameters);
  const GridSettings grid = grid_settings(parameters);
  const GridShape shape = grid_over(bone.surface.mesh, grid, bone.name);
  if (settings.band_m) {
    require_sensible_band(*settings.band_m, shape, bone.surface.mesh, bone.name);
  }
  require_room({&bone, 1}, {&shape, 1}, grid, settings);
  std::optional<CubicField> field;
  const Nanoseconds build_ns = build_and_write(
      options, "field " + bone.name,
      [&](const BuildProgress& progress) {
        field.emplace(build_field(SignedSurface(bone.surface), shape, settings, options.backend.threads, progress));
      },
      [&] {
        if (fs::path(options.out).extension() == ".cdf") {
          write_discregrid(*field, options.out);
        } else {
          save_field(*field, surface_digest(bone.surface), options.out);
        }
      });
  const FieldError& error = field->facts().error;
  const Vec3 size_mm = shape.cell_size_m * 1e3;
  const std::string cells = fmt::format("{} x {} x {} of {:.3g} x {:.3g} x {:.3g} mm", shape.cells[0], shape.cells[1],
                                        shape.cells[2], size_mm[0], size_mm[1], size_mm[2]);
  print_summary(scene, bone, {cells, field->bytes(), error.p99_m, error.largest_m, error.samples}, build_ns,
                options.out);
  return 0;
}

int make_field(const FieldOptions& options) {
  const BackendEntry& backend = find_backend(options.backend.backend);
  if (backend.name != field_backend) {
    throw InputError("--backend " + options.backend.backend, "has no distance field; `sdf` has");
  }
  const Parameters parameters = backend_parameters(backend, options.backend.parameters);
  const bool octree = wants_octree(parameters);
  if (!parameters.word("discregrid").empty()) {
    throw InputError("--param discregrid", "is for fields that are there already; leave it out to build one");
  }
  require_ending(options.out, octree, field_settings(parameters));
  const Scene scene = load_scene(options.scene);
  const Bone& bone = find_bone(scene, options.bone);
  return octree ? write_octree(options, scene, bone, parameters) : write_grid(options, scene, bone, parameters);
}

}  // namespace

void add_field_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<FieldOptions>();
  options->backend.backend = field_backend;
  CLI::App* command = app.add_subcommand("field", "Build one bone's distance field and write it to a file");
  add_scene_options(*command, options->scene);
  add_backend_options(*command, options->backend);
  command->get_option("--backend")->required(false)->description("Backend whose field it is (default: sdf)");
  command->add_option("--bone", options->bone, "Name of the bone (default: the only one)");
  command
      ->add_option("--out", options->out,
                   "The file: .field, .cdf (Discregrid's format), or .octree for a field with max_error_mm")
      ->required();
  command->add_flag("--progress", options->progress_lines, "Print 'progress DONE TOTAL' lines on standard error");
  command->callback([options, &exit_code] { exit_code = make_field(*options); });
}

}  // namespace musclebench

#include <algorithm>
#include <memory>
#include <new>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/cases/advise_case.hpp"
#include "bench/commands/command_options.hpp"
#include "bench/commands/commands.hpp"
#include "bench/process/progress.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {

namespace {
/// The run that makes the input may take this share of the time; the rest is for the configurations.
constexpr double recording_share = 0.4;
/// What is left of an exact answer is rounding.
constexpr double exact_below_m = 1e-9;

struct AdviseOptions {
  SceneOptions scene;
  double depth_mm = 0;
  double seconds = 90;
  double band_mm = 10;
  int threads = 1;
};

std::string millimetres(double metres) {
  return metres < exact_below_m ? "exact" : fmt::format("{:.3g}", metres * 1e3);
}

std::string accuracy_in_words(double error_m) {
  return error_m < exact_below_m ? "exact" : fmt::format("right to {} mm", millimetres(error_m));
}

void print_table(const Advice& advice) {
  const std::string unit_name = advice.unit_of_price ? advice.unit_of_price->text() : "";
  const auto unit = std::find_if(advice.measured.begin(), advice.measured.end(),
                                 [&](const Assessment& a) { return a.configuration.text() == unit_name; });
  fmt::print("  {:<30} {:>9} {:>9} {:>8} {:>8} {:>11} {:>20} {:>7} {:>8} {:>9}\n", "configuration", "p99 mm", "max mm",
             "missed", "false", "ms a frame", "(95 % interval)", "x unit", "build s", "MB");
  for (std::size_t i = 0; i < advice.measured.size(); ++i) {
    const Assessment& row = advice.measured[i];
    const MedianInterval& time = row.collision_ns;
    const std::string ratio =
        unit == advice.measured.end() ? "" : fmt::format("{:.3g}", time.median / unit->collision_ns.median);
    fmt::print("{} {:<30} {:>9} {:>9} {:>8} {:>8} {:>11.4g} {:>20} {:>7} {:>8.2f} {:>9.3g}\n",
               advice.chosen == i ? '*' : ' ', row.configuration.text(), millimetres(row.p99_error_m),
               millimetres(row.max_error_m), row.missed, row.false_contacts, time.median * 1e-6,
               fmt::format("({:.4g} to {:.4g})", time.low * 1e-6, time.high * 1e-6), ratio,
               static_cast<double>(row.build_ns) * 1e-9, static_cast<double>(row.structure_bytes) * 1e-6);
  }
  if (unit != advice.measured.end()) {
    fmt::print("  x unit: time over that of {}\n", unit_name);
  }
  for (const Omission& omission : advice.omitted) {
    fmt::print("  {:<30} not measured: {}\n", omission.configuration.text(), omission.reason);
  }
}

/// The fastest of the others that hold the depth.
const Assessment* runner_up(const Advice& advice, double depth_m) {
  const Assessment* next = nullptr;
  for (std::size_t i = 0; i < advice.measured.size(); ++i) {
    const Assessment& row = advice.measured[i];
    if (i != advice.chosen && row.p99_error_m <= depth_m &&
        (next == nullptr || row.collision_ns.median < next->collision_ns.median)) {
      next = &row;
    }
  }
  return next;
}

std::string command_for(const AdviseOptions& options, const Configuration& configuration) {
  std::string command =
      fmt::format("musclebench run {} --backend {}", options.scene.choice.scene, configuration.backend);
  for (const auto& [name, value] : configuration.parameters) {
    command += fmt::format(" --param {}={}", name, format_parameter_value(value));
  }
  if (!options.scene.choice.preset.empty()) {
    command += " --preset " + options.scene.choice.preset;
  }
  for (const std::string& assignment : options.scene.loop) {
    command += fmt::format(" --loop '{}'", assignment);
  }
  if (options.scene.frames > 0) {
    command += fmt::format(" --frames {}", options.scene.frames);
  }
  if (!options.scene.choice.data.empty()) {
    command += fmt::format(" --data '{}'", options.scene.choice.data);
  }
  return options.threads > 1 ? fmt::format("{} --threads {}", command, options.threads) : command;
}

void print_lines(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    fmt::print("{}\n", line);
  }
}

void print_verdict(const Advice& advice, const AdviseOptions& options, const std::vector<std::string>& reasons) {
  if (advice.measured.empty()) {
    fmt::print("\nNothing could be measured; the reasons are above.\n");
    return;
  }
  if (!advice.chosen) {
    const Assessment& best = advice.measured[*advice.best];
    fmt::print(
        "\nNo configuration holds {} mm. The best found is {}: {:.3g} mm (99th percentile), largest {:.3g} mm, "
        "{:.4g} ms a frame.\n",
        options.depth_mm, best.configuration.text(), best.p99_error_m * 1e3, best.max_error_m * 1e3,
        best.collision_ns.median * 1e-6);
    print_lines(reasons);
    return;
  }
  const Assessment& chosen = advice.measured[*advice.chosen];
  fmt::print("\nTake {}: 99 of 100 contacts are {}, at {:.4g} ms a frame and {:.3g} MB.\n", chosen.configuration.text(),
             accuracy_in_words(chosen.p99_error_m), chosen.collision_ns.median * 1e-6,
             static_cast<double>(chosen.structure_bytes) * 1e-6);
  if (const Assessment* next = runner_up(advice, options.depth_mm * 1e-3)) {
    fmt::print("The next that holds {} mm is {}: {:.3g} times its time, {:.3g} MB.\n", options.depth_mm,
               next->configuration.text(), next->collision_ns.median / chosen.collision_ns.median,
               static_cast<double>(next->structure_bytes) * 1e-6);
  } else {
    fmt::print("No other configuration that was measured holds {} mm.\n", options.depth_mm);
  }
  print_lines(reasons);
  fmt::print("  {}\n", command_for(options, chosen.configuration));
}

AdviceInput run_with_progress(const Scene& scene, double seconds) {
  Progress progress(progress_style(false), "exact run of " + scene.name, scene.loop.frames);
  return run_exactly(scene, seconds, [&](int done) { progress.show(done); });
}

/// Nothing, with the reason, for a configuration that can't be measured.
std::optional<Assessment> try_out(const Scene& scene, const Configuration& configuration, const AdviseOptions& options,
                                  KeptFrames& frames, std::string& reason) {
  std::optional<Progress> progress;
  const auto report = [&](int done, int total) {
    if (!progress) progress.emplace(progress_style(false), "trying " + configuration.text(), total);
    progress->show(done);
  };
  try {
    return assess(scene, configuration, {options.band_mm * 1e-3, options.threads}, frames, reason, report);
  } catch (const InputError& refused) {
    reason = refused.what();
  } catch (const std::bad_alloc&) {
    reason = "there is not enough memory";
  }
  return std::nullopt;
}

int advise(const AdviseOptions& options) {
  const Nanoseconds start_ns = monotonic_now_ns();
  std::vector<AdvisePlan> plans = advise_plans();
  const Scene scene = load_scene(options.scene);
  require_a_choice(scene);
  const AdviceInput input = run_with_progress(scene, options.seconds * recording_share);
  if (input.frames->header().frames() == 0) {
    throw InputError("--seconds", fmt::format("no frame of the exact run could be kept within {:.0f} s; give more",
                                              options.seconds * recording_share));
  }
  const double left_s = options.seconds - static_cast<double>(monotonic_now_ns() - start_ns) * 1e-9;
  const AdviceRequest request{options.depth_mm * 1e-3, left_s, std::move(plans)};
  const Advice advice = find_advice(request, [&](const Configuration& configuration, std::string& reason) {
    return try_out(scene, configuration, options, *input.frames, reason);
  });
  fmt::print("{}: wanted is a depth error of at most {} mm in 99 of 100 contacts\n", scene.name, options.depth_mm);
  fmt::print("Asked were {} of {} frames of the exact run{}, {} true contacts; {} thread{}\n\n",
             input.frames->header().frames(), scene.loop.frames,
             input.frames_run < scene.loop.frames
                 ? fmt::format(" (only its first {}: the time was up)", input.frames_run)
                 : "",
             advice.measured.empty() ? 0 : advice.measured.front().true_contacts, options.threads,
             options.threads == 1 ? "" : "s");
  print_table(advice);
  print_verdict(advice, options, explain(advice, request, {input.frames->header().frames(), scene.loop.frames}));
  return advice.chosen ? 0 : exit_not_held;
}

}  // namespace

void add_advise_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<AdviseOptions>();
  CLI::App* command = app.add_subcommand(
      "advise", "Measure which backend and resolution hold a wanted depth error on a scene, and name the one to take");
  add_scene_options(*command, options->scene);
  command->add_option("--depth-mm", options->depth_mm, "Wanted: the 99th percentile of the depth error, mm")
      ->required()
      ->check(positive_and_finite());
  command->add_option("--seconds", options->seconds, "Time for all of it (default: 90)")->check(positive_and_finite());
  command->add_option("--band-mm", options->band_mm, "Errors count so far from a bone's surface (default: 10)")
      ->check(positive_and_finite());
  add_threads_option(*command, options->threads);
  command->callback([options, &exit_code] { exit_code = advise(*options); });
}

}  // namespace musclebench

#include <algorithm>
#include <functional>
#include <memory>
#include <new>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/cases/advise_arms.hpp"
#include "bench/cases/advise_case.hpp"
#include "bench/cases/safe_steps.hpp"
#include "bench/commands/command_options.hpp"
#include "bench/commands/commands.hpp"
#include "bench/process/progress.hpp"
#include "bench/results/advice_json.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {

namespace {
/// The run that makes the input may take this share of the time; the rest is for the configurations.
constexpr double recording_share = 0.4;
/// What is left of an exact answer is rounding.
constexpr double exact_below_m = 1e-9;

/// Of each muscle, followed for its moment arm.
constexpr int followed_fibres = 100;

struct AdviseOptions {
  SceneOptions scene;
  double depth_mm = 0;
  double moment_arm_mm = 0;  ///< 0: the depth is asked about
  double seconds = 90;
  double band_mm = 10;
  int threads = 1;
  std::string safe_steps;
  bool json = false;

  [[nodiscard]] bool asks_for_arms() const { return moment_arm_mm > 0; }
  [[nodiscard]] double wanted_mm() const { return asks_for_arms() ? moment_arm_mm : depth_mm; }
};

std::string millimetres(double metres) {
  return metres < exact_below_m ? "exact" : fmt::format("{:.3g}", metres * 1e3);
}

std::string accuracy_in_words(double error_m) {
  return error_m < exact_below_m ? "exact" : fmt::format("right to {} mm", millimetres(error_m));
}

std::string count_in_words(const std::optional<ContactCounts>& contacts, long ContactCounts::*count) {
  return contacts ? fmt::format("{}", (*contacts).*count) : "";
}

void print_table(const Advice& advice, bool is_of_arms) {
  const std::string unit_name = advice.unit_of_price ? advice.unit_of_price->text() : "";
  const auto unit = std::find_if(advice.measured.begin(), advice.measured.end(),
                                 [&](const Assessment& a) { return a.configuration.text() == unit_name; });
  fmt::print("  {:<30} {:>9} {:>9} {:>8} {:>8} {:>11} {:>20} {:>7} {:>8} {:>9}\n", "configuration",
             is_of_arms ? "RMS mm" : "p99 mm", "max mm", is_of_arms ? "" : "missed", is_of_arms ? "" : "false",
             "ms a frame", "(95 % interval)", "x unit", "build s", "MB");
  for (std::size_t i = 0; i < advice.measured.size(); ++i) {
    const Assessment& row = advice.measured[i];
    const MedianInterval& time = row.collision_ns;
    const std::string ratio =
        unit == advice.measured.end() ? "" : fmt::format("{:.3g}", time.median / unit->collision_ns.median);
    fmt::print("{} {:<30} {:>9} {:>9} {:>8} {:>8} {:>11.4g} {:>20} {:>7} {:>8.2f} {:>9.3g}\n",
               advice.chosen == i ? '*' : ' ', row.configuration.text(), millimetres(row.error_m),
               millimetres(row.max_error_m), count_in_words(row.contacts, &ContactCounts::missed),
               count_in_words(row.contacts, &ContactCounts::wrong), time.median * 1e-6,
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

/// The fastest of the others that hold.
const Assessment* runner_up(const Advice& advice, double wanted_m) {
  const Assessment* next = nullptr;
  for (std::size_t i = 0; i < advice.measured.size(); ++i) {
    const Assessment& row = advice.measured[i];
    if (i != advice.chosen && row.error_m <= wanted_m &&
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
        "\nNo configuration holds {} mm. The best found is {}: {:.3g} mm ({}), largest {:.3g} mm, {:.4g} ms a frame.\n",
        options.wanted_mm(), best.configuration.text(), best.error_m * 1e3,
        options.asks_for_arms() ? "RMS over the motion" : "99th percentile", best.max_error_m * 1e3,
        best.collision_ns.median * 1e-6);
    print_lines(reasons);
    return;
  }
  const Assessment& chosen = advice.measured[*advice.chosen];
  fmt::print("\nTake {}: {} {}, at {:.4g} ms a frame and {:.3g} MB.\n", chosen.configuration.text(),
             options.asks_for_arms() ? "its moment arms are" : "99 of 100 contacts are",
             accuracy_in_words(chosen.error_m), chosen.collision_ns.median * 1e-6,
             static_cast<double>(chosen.structure_bytes) * 1e-6);
  if (const Assessment* next = runner_up(advice, options.wanted_mm() * 1e-3)) {
    fmt::print("The next that holds {} mm is {}: {:.3g} times its time, {:.3g} MB.\n", options.wanted_mm(),
               next->configuration.text(), next->collision_ns.median / chosen.collision_ns.median,
               static_cast<double>(next->structure_bytes) * 1e-6);
  } else {
    fmt::print("No other configuration that was measured holds {} mm.\n", options.wanted_mm());
  }
  print_lines(reasons);
  fmt::print("  {}\n", command_for(options, chosen.configuration));
}

/// The progress of what takes long, by a name that is known when it begins.
std::function<void(int done)> reported(std::optional<Progress>& progress, const std::string& what, int total) {
  return [&progress, what, total](int done) {
    if (!progress) progress.emplace(progress_style(false), what, total);
    progress->show(done);
  };
}

/// How a configuration is measured; nothing, with the reason, for one that can't be.
using Measure = std::function<std::optional<Assessment>(const Configuration& configuration, std::string& reason,
                                                        const std::function<void(int done, int total)>& report)>;

/// Why the configuration's runs go wrong at the scene's step; nothing where it is not known that they do.
using SafetyDoubt = std::function<std::optional<std::string>(const Configuration& configuration)>;

SafetyDoubt doubts_of(const Scene& scene, const AdviseOptions& options) {
  if (options.safe_steps.empty()) return [](const Configuration&) { return std::nullopt; };
  return [&scene, known = read_safe_steps(options.safe_steps)](const Configuration& configuration) {
    const BackendEntry& backend = find_backend(configuration.backend);
    return why_unsafe(known, scene, backend.name, name_of(scene.response.value_or(backend.default_response)));
  };
}

Advice find_with_progress(const AdviceRequest& request, const SafetyDoubt& doubt, const Measure& measure) {
  return find_advice(request, [&](const Configuration& configuration, std::string& reason) {
    if (const std::optional<std::string> unsafe = doubt(configuration)) {
      reason = *unsafe;
      return std::optional<Assessment>();
    }
    std::optional<Progress> progress;
    const auto report = [&](int done, int total) { reported(progress, "trying " + configuration.text(), total)(done); };
    try {
      return measure(configuration, reason, report);
    } catch (const InputError& refused) {
      reason = refused.what();
    } catch (const std::bad_alloc&) {
      reason = "there is not enough memory";
    }
    return std::optional<Assessment>();
  });
}

/// What the advice rests on.
struct Basis {
  int frames = 0;      ///< that were asked
  int frames_run = 0;  ///< by the exact run
};

std::string cut_short(const Scene& scene, const Basis& basis) {
  return basis.frames_run < scene.loop.frames ? fmt::format(" (only its first {}: the time was up)", basis.frames_run)
                                              : "";
}

std::string threads_in_words(int threads) { return fmt::format("{} thread{}", threads, threads == 1 ? "" : "s"); }

/// `said` goes before the table.
void print_advice(const Scene& scene, const AdviseOptions& options, const AdviceRequest& request, const Advice& advice,
                  const Basis& basis, const std::string& said) {
  const std::vector<std::string> reasons = explain(advice, request, {basis.frames, scene.loop.frames});
  if (!options.json) {
    fmt::print("{}\n", said);
    print_table(advice, options.asks_for_arms());
    print_verdict(advice, options, reasons);
    return;
  }
  Json json = {{"scene", scene.name},
               {"wanted", {{"of", options.asks_for_arms() ? "moment_arm_rms" : "depth_p99"}, {"m", request.wanted_m}}},
               {"frames", {{"asked", basis.frames}, {"run", basis.frames_run}, {"all", scene.loop.frames}}},
               {"threads", options.threads}};
  json.update(json_of(advice, request.wanted_m));
  json["command"] = advice.chosen ? Json(command_for(options, advice.measured[*advice.chosen].configuration)) : Json();
  json["reasons"] = reasons;
  fmt::print("{}\n", text_of(json, 2));
}

Advice advise_on_depth(const Scene& scene, const AdviseOptions& options, AdviceRequest request, Nanoseconds start_ns) {
  std::optional<Progress> progress;
  const double run_s = options.seconds * recording_share;
  const AdviceInput input =
      run_exactly(scene, run_s, reported(progress, "exact run of " + scene.name, scene.loop.frames));
  progress.reset();
  if (input.frames->header().frames() == 0) {
    throw InputError("--seconds",
                     fmt::format("no frame of the exact run could be kept within {:.0f} s; give more", run_s));
  }
  request.seconds -= static_cast<double>(monotonic_now_ns() - start_ns) * 1e-9;
  const SafetyDoubt doubt = doubts_of(scene, options);
  Advice advice = find_with_progress(
      request, doubt,
      [&](const Configuration& configuration, std::string& reason, const std::function<void(int, int)>& report) {
        return assess(scene, configuration, {options.band_mm * 1e-3, options.threads}, *input.frames, reason, report);
      });
  const Basis basis{input.frames->header().frames(), input.frames_run};
  const bool is_known = !advice.measured.empty() && advice.measured.front().contacts;
  const std::string said =
      fmt::format("{}: wanted is a depth error of at most {} mm in 99 of 100 contacts\n", scene.name,
                  options.depth_mm) +
      fmt::format("Asked were {} of {} frames of the exact run{}, {} true contacts; {}\n", basis.frames,
                  scene.loop.frames, cut_short(scene, basis), is_known ? advice.measured.front().contacts->real : 0,
                  threads_in_words(options.threads));
  print_advice(scene, options, request, advice, basis, said);
  return advice;
}

Advice advise_on_arms(const Scene& scene, const AdviseOptions& options, AdviceRequest request, Nanoseconds start_ns) {
  std::optional<Progress> progress;
  const ArmInput input = run_for_arms(scene, options.seconds * recording_share,
                                      reported(progress, "exact run of " + scene.name, scene.loop.frames));
  progress.reset();
  request.seconds -= static_cast<double>(monotonic_now_ns() - start_ns) * 1e-9;
  const SafetyDoubt doubt = doubts_of(scene, options);
  Advice advice = find_with_progress(
      request, doubt,
      [&](const Configuration& configuration, std::string& reason, const std::function<void(int, int)>& report) {
        return assess_arms(scene, configuration, options.threads, input, reason,
                           [&](int done) { report(done, input.frames_run); });
      });
  const Basis basis{input.frames_run, input.frames_run};
  const std::string said =
      fmt::format("{}: wanted are moment arms within {} mm (RMS over the motion) of the exact run's\n", scene.name,
                  options.moment_arm_mm) +
      fmt::format("Each configuration moved the muscle for {} of {} frames{}; {}\n", basis.frames, scene.loop.frames,
                  cut_short(scene, basis), threads_in_words(options.threads)) +
      fmt::format("Rounding alone moves the exact run's by {:.2g} mm{}\n", input.floor_m * 1e3,
                  input.floor_m > request.wanted_m
                      ? ": more than is wanted, so that what holds it here may not hold it in another run"
                      : "");
  print_advice(scene, options, request, advice, basis, said);
  return advice;
}

int advise(const AdviseOptions& options) {
  const Nanoseconds start_ns = monotonic_now_ns();
  const AdviceRequest request{options.wanted_mm() * 1e-3, options.seconds, advise_plans()};
  SceneOptions named = options.scene;
  if (options.asks_for_arms()) named.choice.fibres = {followed_fibres, "--moment-arm-mm"};
  const Scene scene = load_scene(named);
  require_a_choice(scene);
  const Advice advice = options.asks_for_arms() ? advise_on_arms(scene, options, request, start_ns)
                                                : advise_on_depth(scene, options, request, start_ns);
  return advice.chosen ? 0 : exit_not_held;
}

}  // namespace

void add_advise_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<AdviseOptions>();
  CLI::App* command = app.add_subcommand(
      "advise", "Measure which backend and resolution hold a wanted error on a scene, and name the one to take");
  add_scene_options(*command, options->scene);
  CLI::Option* depth =
      command->add_option("--depth-mm", options->depth_mm, "Wanted: the 99th percentile of the depth error, mm")
          ->check(positive_and_finite());
  CLI::Option* arm = command
                         ->add_option("--moment-arm-mm", options->moment_arm_mm,
                                      "Wanted instead: the error of the muscle's moment arm, RMS over the motion, mm")
                         ->check(positive_and_finite())
                         ->excludes(depth);
  command->add_option("--seconds", options->seconds, "Time for all of it (default: 90)")->check(positive_and_finite());
  command->add_option("--band-mm", options->band_mm, "Errors count so far from a bone's surface (default: 10)")
      ->check(positive_and_finite());
  add_threads_option(*command, options->threads);
  command->add_option("--safe-step", options->safe_steps,
                      "safe_step.json of tools/safe-step: leave out backends whose runs go wrong at the scene's step");
  command->add_flag("--json", options->json, "Print the advice as JSON");
  command->callback([options, depth, arm, &exit_code] {
    if (depth->empty() && arm->empty()) throw CLI::RequiredError("--depth-mm or --moment-arm-mm");
    exit_code = advise(*options);
  });
}

}  // namespace musclebench

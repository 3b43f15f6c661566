#include <algorithm>
#include <cmath>
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
#include "bench/commands/effect_trials.hpp"
#include "bench/process/exit_code.hpp"
#include "bench/process/progress.hpp"
#include "bench/results/advice_json.hpp"
#include "core/base/input_error.hpp"
#include "core/base/machine_state.hpp"

namespace musclebench {

namespace {
/// What is left of an exact answer is rounding.
constexpr double exact_below_m = 1e-9;

/// Of each muscle, followed for its moment arm.
constexpr int followed_fibres = 100;

struct AdviseOptions {
  SceneOptions scene;
  double depth_mm = 0;
  double moment_arm_mm = 0;  ///< 0: the depth is asked about
  double seconds = 120;
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

/// An interval is not known of few frames.
std::string interval_in_words(const MedianEstimate& time) {
  return std::isnan(time.low) ? "" : fmt::format("({:.4g} to {:.4g})", time.low * 1e-6, time.high * 1e-6);
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
    const MedianEstimate& time = row.collision_ns;
    const std::string ratio =
        unit == advice.measured.end() ? "" : fmt::format("{:.3g}", time.median / unit->collision_ns.median);
    fmt::print("{} {:<30} {:>9} {:>9} {:>8} {:>8} {:>11.4g} {:>20} {:>7} {:>8.2f} {:>9.3g}\n",
               advice.chosen == i ? '*' : ' ', row.configuration.text(), millimetres(row.error_m),
               millimetres(row.max_error_m), count_in_words(row.contacts, &ContactCounts::missed),
               count_in_words(row.contacts, &ContactCounts::wrong), time.median * 1e-6, interval_in_words(time), ratio,
               static_cast<double>(row.build_ns) * 1e-9, static_cast<double>(row.structure_bytes) * 1e-6);
  }
  if (unit != advice.measured.end()) {
    fmt::print("  x unit: time over that of {}\n", unit_name);
  }
  for (const Omission& omission : advice.omitted) {
    fmt::print("  {:<30} not measured: {}\n", omission.configuration.text(), omission.reason);
  }
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

std::string promise_in_words(const Assessment& row, const AdviseOptions& options) {
  if (options.asks_for_arms()) {
    return fmt::format("moment arms within {:.3g} mm of the exact run's (RMS over the motion)", row.error_m * 1e3);
  }
  if (!row.contacts) return "";
  if (row.error_m < exact_below_m) return "the exact surface";
  return fmt::format("a surface within {:.3g} mm of the true one at 99 of 100 contacts", row.error_m * 1e3);
}

std::string trial_in_words(const Trial& trial) {
  const std::string surface =
      trial.surface_depth_m ? fmt::format(", the surface {:.3g} mm", *trial.surface_depth_m * 1e3) : "";
  return fmt::format("nodes at most {:.3g} mm deep{}, {} nodes tunnelled, {:.3g} ms a frame, status {}{}{}",
                     trial.node_depth_m * 1e3, surface, trial.tunnelled_nodes, trial.frame_ns * 1e-6, trial.status,
                     trial.status_detail.empty() ? "" : ": ", trial.status_detail);
}

/// What promised to hold, was run, and did not.
void print_refused(const Advice& advice, const AdviseOptions& options) {
  for (const Assessment& row : advice.measured) {
    if (row.refusal.empty()) continue;
    fmt::print("Not {}: it promised {}, but {}.\n", row.configuration.text(), promise_in_words(row, options),
               row.refusal);
  }
}

void print_taken(const Assessment& chosen, const AdviseOptions& options) {
  fmt::print("\nTake {}: {:.4g} ms of collision a frame, {:.3g} MB.\n", chosen.configuration.text(),
             chosen.collision_ns.median * 1e-6, static_cast<double>(chosen.structure_bytes) * 1e-6);
  fmt::print("  promised: {}\n", promise_in_words(chosen, options));
  fmt::print("  found, in its own run of all {} frames: {}\n", chosen.trial->frames, trial_in_words(*chosen.trial));
}

void print_verdict(const Advice& advice, const AdviseOptions& options, const std::vector<std::string>& reasons) {
  if (advice.chosen) {
    const Assessment& chosen = advice.measured[*advice.chosen];
    print_taken(chosen, options);
    print_refused(advice, options);
    print_lines(reasons);
    fmt::print("  {}\n", command_for(options, chosen.configuration));
    return;
  }
  if (advice.untried) {
    const Assessment& next = advice.measured[*advice.untried];
    fmt::print(
        "\nThe time was up ({:g} s of CPU time) before a run over the whole motion held {} mm. The next configuration "
        "to try is {}: it promises {}. Give more --seconds.\n",
        options.seconds, options.wanted_mm(), next.configuration.text(), promise_in_words(next, options));
  } else if (advice.measured.empty()) {
    fmt::print("\nNothing could be measured; the reasons are above.\n");
  } else {
    const Assessment& best = advice.measured[*advice.best];
    fmt::print("\nNo configuration holds {} mm. The best found is {}: {:.3g} mm ({}), largest {:.3g} mm.\n",
               options.wanted_mm(), best.configuration.text(), best.error_m * 1e3,
               options.asks_for_arms() ? "RMS over the motion" : "99th percentile", best.max_error_m * 1e3);
  }
  print_refused(advice, options);
  print_lines(reasons);
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

Advice find_with_progress(const Scene& scene, int threads, const AdviceRequest& request, const SafetyDoubt& doubt,
                          const Measure& measure) {
  const auto try_with_progress = [&](const Configuration& configuration, double seconds) {
    std::optional<Progress> progress;
    return try_out(scene, configuration, threads, seconds,
                   reported(progress, "running " + configuration.text(), scene.loop.frames));
  };
  const auto assess_with_progress = [&](const Configuration& configuration, std::string& reason) {
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
      reason = "not enough memory";
    }
    return std::optional<Assessment>();
  };
  return find_advice(request, assess_with_progress, try_with_progress);
}

/// The exact run was not over when the time was up.
int end_without_exact_run(const Scene& scene, const AdviseOptions& options, int frames_run) {
  fmt::print(stderr,
             "musclebench: --seconds: {:g} s of CPU time ended in frame {} of {} of the exact run of {}, before any "
             "measurement; give about {:.0f} s\n",
             options.seconds, frames_run, scene.loop.frames, scene.name,
             std::max(1.0, std::ceil(4 * options.seconds * scene.loop.frames / std::max(1, frames_run))));
  return exit_out_of_time;
}

/// 0: what is named was run, and held.
int exit_code_of(const Advice& advice) {
  if (advice.chosen) return 0;
  return advice.untried ? exit_out_of_time : exit_not_held;
}

std::string threads_in_words(int threads) { return fmt::format("{} thread{}", threads, threads == 1 ? "" : "s"); }

/// `said` goes before the table; `asked` frames were.
void print_advice(const Scene& scene, const AdviseOptions& options, const AdviceRequest& request, const Advice& advice,
                  int asked, const std::string& said) {
  const std::vector<std::string> reasons = explain(advice, request, {asked, scene.loop.frames});
  if (!options.json) {
    fmt::print("{}\n", said);
    print_table(advice, options.asks_for_arms());
    print_verdict(advice, options, reasons);
    return;
  }
  Json json = {
      {"scene", scene.name},
      {"wanted", {{"of", options.asks_for_arms() ? "moment_arm_rms" : "surface_offset_p99"}, {"m", request.wanted_m}}},
      {"frames", {{"asked", asked}, {"all", scene.loop.frames}}},
      {"threads", options.threads}};
  json.update(json_of(advice, request.wanted_m));
  json["command"] = advice.chosen ? Json(command_for(options, advice.measured[*advice.chosen].configuration)) : Json();
  json["reasons"] = reasons;
  fmt::print("{}\n", text_of(json, 2));
}

int advise_on_depth(const Scene& scene, const AdviseOptions& options, AdviceRequest request, Nanoseconds start_ns) {
  std::optional<Progress> progress;
  const AdviceInput input =
      run_exactly(scene, options.seconds, reported(progress, "exact run of " + scene.name, scene.loop.frames));
  progress.reset();
  if (input.frames_run < scene.loop.frames) return end_without_exact_run(scene, options, input.frames_run);
  request.seconds -= static_cast<double>(process_cpu_ns() - start_ns) * 1e-9;
  const AssessOptions assess_options{options.band_mm * 1e-3, options.threads, options.seconds / 4};
  const Advice advice = find_with_progress(
      scene, options.threads, request, doubts_of(scene, options),
      [&](const Configuration& configuration, std::string& reason, const std::function<void(int, int)>& report) {
        return assess(scene, configuration, assess_options, *input.frames, reason, report);
      });
  const int asked = input.frames->header().frames();
  const bool is_known = !advice.measured.empty() && advice.measured.front().contacts;
  const std::string said =
      fmt::format(
          "{}: wanted is an error of {} mm: no node deeper, the surface no farther from the true one at 99 of 100 "
          "contacts\n",
          scene.name, options.depth_mm) +
      fmt::format("Measured on {} of {} frames of the exact run, {} true contacts; {}\n", asked, scene.loop.frames,
                  is_known ? advice.measured.front().contacts->real : 0, threads_in_words(options.threads));
  print_advice(scene, options, request, advice, asked, said);
  return exit_code_of(advice);
}

int advise_on_arms(const Scene& scene, const AdviseOptions& options, AdviceRequest request, Nanoseconds start_ns) {
  std::optional<Progress> progress;
  const ArmInput input =
      run_for_arms(scene, options.seconds, reported(progress, "exact run of " + scene.name, scene.loop.frames));
  progress.reset();
  if (input.frames_run < scene.loop.frames) return end_without_exact_run(scene, options, input.frames_run);
  request.seconds -= static_cast<double>(process_cpu_ns() - start_ns) * 1e-9;
  request.bounds_depth = false;
  const Advice advice = find_with_progress(
      scene, options.threads, request, doubts_of(scene, options),
      [&](const Configuration& configuration, std::string& reason, const std::function<void(int, int)>& report) {
        return assess_arms(scene, configuration, options.threads, input, reason,
                           [&](int done) { report(done, input.frames_run); });
      });
  const std::string said =
      fmt::format("{}: wanted are moment arms within {} mm (RMS over the motion) of the exact run's moment arms\n",
                  scene.name, options.moment_arm_mm) +
      fmt::format("Each configuration moved the muscle for all {} frames; {}\n", scene.loop.frames,
                  threads_in_words(options.threads)) +
      fmt::format("Rounding alone changes the exact run's moment arms by {:.2g} mm{}\n", input.floor_m * 1e3,
                  input.floor_m > request.wanted_m
                      ? ", more than the wanted error: a configuration that holds it here may miss it in another run"
                      : "");
  print_advice(scene, options, request, advice, scene.loop.frames, said);
  return exit_code_of(advice);
}

int advise(const AdviseOptions& options) {
  const AdviceRequest request{options.wanted_mm() * 1e-3, options.seconds, advise_plans()};
  SceneOptions named = options.scene;
  if (options.asks_for_arms()) named.choice.fibres = {followed_fibres, "--moment-arm-mm"};
  Scene scene = load_scene(named);
  add_wanted_effects(choice_of(named), scene);
  const Nanoseconds start_ns = process_cpu_ns();
  require_a_choice(scene);
  return options.asks_for_arms() ? advise_on_arms(scene, options, request, start_ns)
                                 : advise_on_depth(scene, options, request, start_ns);
}

}  // namespace

void add_advise_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<AdviseOptions>();
  CLI::App* command =
      app.add_subcommand("advise", "Find the cheapest backend and resolution that hold a wanted error on a scene");
  command->footer(
      "Example: musclebench advise synthetic/iliacus --depth-mm 0.5\n"
      "The program measures the error of each candidate. It then runs the cheapest candidate over the whole motion, "
      "and recommends it if the error held.\n"
      "Exit codes: 0 a candidate held, 1 none did, 2 bad input, 5 the time was up first.");
  add_scene_options(*command, options->scene);
  CLI::Option* depth =
      command
          ->add_option("--depth-mm", options->depth_mm,
                       "Wanted depth error, mm: no node is deeper, and at 99 of 100 contacts the backend's surface is "
                       "no farther from the true surface")
          ->check(positive_and_finite());
  CLI::Option* arm = command
                         ->add_option("--moment-arm-mm", options->moment_arm_mm,
                                      "Wanted error of the muscle's moment arm, mm, RMS over the motion")
                         ->check(positive_and_finite())
                         ->excludes(depth);
  command->add_option("--seconds", options->seconds, "CPU time for the whole search, s (default: 120)")
      ->check(positive_and_finite());
  command
      ->add_option("--band-mm", options->band_mm,
                   "Measure errors at contacts no farther than this from a bone's surface, mm (default: 10)")
      ->check(positive_and_finite());
  add_threads_option(*command, options->threads);
  command->add_option("--safe-step", options->safe_steps,
                      "File safe_step.json of tools/safe-step: leave out backends that go wrong at the scene's step");
  command->add_flag("--json", options->json, "Print the advice as JSON");
  command->callback([options, depth, arm, &exit_code] {
    if (depth->empty() && arm->empty()) throw CLI::RequiredError("--depth-mm or --moment-arm-mm");
    exit_code = advise(*options);
  });
}

}  // namespace musclebench

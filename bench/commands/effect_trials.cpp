#include "bench/commands/effect_trials.hpp"

#include <utility>

#include <fmt/format.h>

#include "bench/commands/command_options.hpp"
#include "bench/process/progress.hpp"
#include "bench/results/kept_effects.hpp"
#include "bench/trials/addition.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {

void add_wanted_option(CLI::App& command, std::vector<std::string>& wanted) {
  command.add_option(
      "--wanted", wanted,
      "What the scene wants, key=value, such as surface_mm=0.1; overrides its [wanted]; may be repeated");
}

std::map<std::string, ParameterValue> wanted_overrides(const std::vector<std::string>& wanted) {
  std::map<std::string, ParameterValue> values = parse_assignments(wanted, "--wanted", wanted_parameters());
  (void)Parameters(wanted_parameters(), values, "--wanted");
  return values;
}

EffectChoice choose_effects_with_progress(Scene& scene, const SearchOptions& options) {
  const int frames = scene.loop.frames;
  return choose_effects(
      scene,
      [&](const Scene& tried, const TrialRequest& request, const std::string& what) {
        Progress progress(progress_style(false), fmt::format("trial of {}: {}", scene.name, what), frames);
        return try_effects(tried, request, [&](int done) { progress.show(done); });
      },
      options);
}

namespace {

/// What an earlier search found, unless that is asked again.
EffectChoice find_or_choose_effects(const SceneChoice& choice, Scene& scene, const WantedEffectsOptions& options) {
  const auto file = kept_effects_file(scene, resolved_scene(choice, scene));
  if (file && !options.searches_again) {
    Scene with = scene;
    const std::optional<EffectChoice> kept = add_kept_effects(*file, with);
    if (kept && (kept->judged_all_frames || !options.judges_the_end)) {
      scene = std::move(with);
      fmt::print(stderr, "musclebench: {}: effects as an earlier search found them ({})\n", scene.name, file->string());
      return *kept;
    }
  }
  if (options.before_search) options.before_search(with_all_additions(scene));
  fmt::print(stderr, "musclebench: {}: looking for effects by trial runs\n", scene.name);
  // The run itself judges all frames, so that a first search need not.
  EffectChoice found = choose_effects_with_progress(scene, {.judges_the_end = options.judges_the_end});
  if (found.was_refused) throw InputError(scene.file, "no trial can be run: " + found.unmet.front().text());
  if (file) keep_effects(*file, scene, found);
  return found;
}

}  // namespace

bool add_wanted_effects(const SceneChoice& choice, Scene& scene, const WantedEffectsOptions& options) {
  if (!waits_for_trials(scene)) return false;
  const EffectChoice found = find_or_choose_effects(choice, scene, options);
  scene.warnings = warnings_of(scene);
  print_warnings(scene.name, scene.warnings);
  scene.auto_effects.resolved_text = resolved_scene(choice, scene);
  for (const AddedEffect& added : found.added) {
    fmt::print(stderr, "musclebench: {}: added {} [{}]: {}\n", scene.name, added.effect, added.rule, added.reason);
  }
  for (const Unmet& unmet : found.unmet) {
    scene.warnings.push_back({"wanted", "does not hold: " + unmet.text()});
    print_warnings(scene.name, {scene.warnings.back()});
  }
  return found.holds() && !found.judged_all_frames;
}

namespace {

std::string wanted_in_words(const Wanted& wanted) {
  std::string words =
      fmt::format("wanted: depth {:g} mm, volume {:g} %, {}, back within {:g} mm", 1e3 * wanted.surface_m,
                  100 * wanted.volume_share,
                  wanted.nothing_passes ? "nothing passes" : "no node passes and at most 1 % of triangles",
                  1e3 * wanted.returned_m);
  if (wanted.moment_arm_m) words += ", fibres under tension";
  return words;
}

std::string line_of(const TriedSet& tried) {
  return fmt::format("  {}{}: {} [{:.2g} s]", tried.change,
                     tried.was_stopped ? fmt::format(" (ended in frame {})", tried.frames) : "", tried.verdict,
                     1e-9 * static_cast<double>(tried.cpu_ns));
}

}  // namespace

std::vector<std::string> lines_of(const Scene& scene, const EffectChoice& choice) {
  std::vector<std::string> lines{wanted_in_words(scene.wanted), "trial runs:"};
  for (const TriedSet& tried : choice.tried) lines.push_back(line_of(tried));
  for (const AddedEffect& added : choice.added) {
    lines.push_back(fmt::format("added {} [{}]: {}", added.effect, added.rule, added.reason));
  }
  for (const std::string& needless : choice.needless) lines.push_back("needless " + needless);
  for (const Unmet& unmet : choice.unmet) {
    lines.push_back("does not hold: " + unmet.what);
    for (const std::string& tried : unmet.tried) lines.push_back("  tried " + tried);
    if (unmet.tried.empty()) lines.emplace_back("  no effect that may be added is a remedy");
  }
  if (choice.holds()) {
    lines.push_back(choice.added.empty() ? "holds all that is wanted as it is"
                                         : "holds all that is wanted with what was added");
  }
  return lines;
}

}  // namespace musclebench

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/commands/command_options.hpp"
#include "bench/commands/commands.hpp"
#include "bench/process/progress.hpp"
#include "bench/process/signals.hpp"
#include "bench/queries/check_queries.hpp"
#include "bench/queries/make_queries.hpp"
#include "bench/queries/query_set_file.hpp"
#include "bench/results/recorded_scene.hpp"
#include "core/base/input_error.hpp"
#include "core/recording/recording_reader.hpp"

namespace musclebench {

namespace {

struct QueriesOptions {
  RecordedScene recorded;
  std::string out;
  std::string check;
  std::string answers;
  QueryChoice choice;
  double band_mm = 10;
  bool progress_lines = false;
};

double megabytes(const std::filesystem::path& path) {
  return 1e-6 * static_cast<double>(std::filesystem::file_size(path));
}

int write_queries(const QueriesOptions& options) {
  RecordingReader recording(options.recorded.recording);
  const RecordingHeader& header = recording.header();
  const Scene scene = load_recorded_scene(header, options.recorded);
  QueryChoice choice = options.choice;
  choice.band_m = 1e-3 * options.band_mm;
  choice.moments = std::min(choice.moments, header.frames());
  QuerySet set;
  {
    std::optional<EndAtOnce> until_written(std::in_place);
    Progress progress(progress_style(options.progress_lines), "queries of " + scene.name, choice.moments);
    set = queries_of(scene, recording, choice, [&](int done) { progress.show(done); });
  }
  set.about =
      fmt::format("{}{}, recorded with {}, sha256 of the recording {}; m, rest frames of the bones", scene.name,
                  scene.preset.empty() ? "" : ", preset " + scene.preset, header.backend, recording.file().sha256);
  std::string digest;
  {
    const HeldSignals held;
    digest = write_query_set(options.out, set);
  }
  std::size_t inside = 0;
  for (const double distance_m : set.distances_m) inside += distance_m < 0 ? 1 : 0;
  fmt::print("{} queries of {}, {} of them inside a bone\n", set.bone.size(), scene.name, inside);
  fmt::print("  moments, steps at each        {:>6}, {}\n", choice.moments,
             std::min(choice.steps, header.steps_per_frame()));
  for (std::int32_t kind = 0; kind <= around_the_bone; ++kind) {
    fmt::print("  {:<28}  {:>6}\n", difficulty_name(kind),
               std::count(set.difficulty.begin(), set.difficulty.end(), kind));
  }
  fmt::print("  size                          {:>6.1f} MB\n  sha256                        {}\n  written to {}\n",
             megabytes(options.out), digest, options.out);
  return 0;
}

void print_errors(const std::string& name, const QueryErrors& errors) {
  if (errors.queries == 0) return;
  fmt::print("{:<28} {:>9} {:>11} {:>12} {:>12.4g} {:>12.4g}\n", name, errors.queries, errors.unanswered,
             errors.wrong_sides, 1e3 * errors.p99_m, 1e3 * errors.largest_m);
}

void print_head() {
  fmt::print("{:<28} {:>9} {:>11} {:>12} {:>12} {:>12}\n", "of", "queries", "unanswered", "wrong side", "p99 error mm",
             "largest mm");
}

int judge_answers(const QuerySet& set, const std::string& path) {
  const std::vector<double> answers = read_answers(path, set);
  print_head();
  for (std::size_t bone = 0; bone < set.bones.size(); ++bone) {
    for (std::int32_t kind = 0; kind <= around_the_bone; ++kind) {
      print_errors(fmt::format("{}, {}", set.bones[bone].name, difficulty_name(kind)),
                   compare_answers(set, answers, [&](std::size_t i) {
                     return set.bone[i] == static_cast<std::int32_t>(bone) && set.difficulty[i] == kind;
                   }));
    }
  }
  print_errors("all", compare_answers(set, answers, [](std::size_t) { return true; }));
  return 0;
}

int check_queries(const QueriesOptions& options) {
  const QuerySet set = read_checked_query_set(options.check);
  fmt::print("{}: {} queries about {} bones\n  {}\n", options.check, set.bone.size(), set.bones.size(), set.about);
  if (!options.answers.empty()) return judge_answers(set, options.answers);
  const std::vector<QuerySetCheck> checks = check_query_set(set);
  print_head();
  bool held = !checks.empty();
  double agreed_m = 0;
  for (const QuerySetCheck& check : checks) {
    print_errors(check.by, check.errors);
    held = check.held() && held;
    agreed_m = check.agreed_m;
  }
  const double gap_m = largest_gap_m(set);
  held = gap_m <= agreed_m && held;
  fmt::print("closest points are within {:.2g} mm of their distances\n{}\n", 1e3 * gap_m, held ? "held" : "NOT held");
  return held ? 0 : exit_not_held;
}

int queries(const QueriesOptions& options) {
  const bool writes = !options.recorded.recording.empty();
  if (writes == !options.check.empty()) {
    throw InputError("queries", "name a recording and --out to write a query set, or --check FILE to check one");
  }
  if (writes && options.out.empty()) throw InputError("--out", "is missing; name the file to write");
  if (writes && !options.answers.empty())
    throw InputError("--answers", "goes with --check FILE; leave the recording out");
  return writes ? write_queries(options) : check_queries(options);
}

}  // namespace

void add_queries_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<QueriesOptions>();
  CLI::App* command =
      app.add_subcommand("queries", "Write points with exact answers for libraries, or check a library's answers");
  command->footer(
      "Examples:\n"
      "  musclebench record synthetic/iliacus --out iliacus.steps\n"
      "  musclebench queries iliacus.steps --out iliacus.queries\n"
      "  musclebench queries --check iliacus.queries\n"
      "  musclebench queries --check iliacus.queries --answers mine.f64\n"
      "datasets/queries/README.md describes the file and has readers for C++ and Python.\n"
      "Exit codes: 0 done, 1 an exact backend differs from the set, 2 bad input.");
  add_recorded_scene_options(*command, options->recorded);
  command->add_option("--out", options->out, "Query set to write");
  command->add_option("--check", options->check, "Query set to check with every exact backend of this build");
  command->add_option("--answers", options->answers,
                      "Signed distances to judge, with --check: one little-endian double a query, negative inside");
  command->add_option("--moments", options->choice.moments, "Moments, evenly over the motion")
      ->capture_default_str()
      ->check(CLI::Range(1, 1'000'000));
  command->add_option("--steps", options->choice.steps, "Successive steps at each moment")
      ->capture_default_str()
      ->check(CLI::Range(1, 1'000'000));
  command->add_option("--band-mm", options->band_mm, "Largest distance of a point from the surface, mm (default: 10)")
      ->check(positive_and_finite());
  command->add_option("--around", options->choice.around, "Hard points about each bone, as well as those of the motion")
      ->capture_default_str()
      ->check(CLI::Range(0, 100'000'000));
  command
      ->add_option("--queries", options->choice.most,
                   "Largest number of points of the motion; of more, only every so many-th node is kept")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000'000}));
  command->add_flag("--progress", options->progress_lines, "Print 'progress DONE TOTAL' lines on standard error");
  command->callback([options, &exit_code] { exit_code = queries(*options); });
}

}  // namespace musclebench

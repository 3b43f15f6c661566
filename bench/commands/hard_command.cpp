#include <algorithm>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <sched.h>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "backends/registry.hpp"
#include "bench/commands/command_options.hpp"
#include "bench/commands/commands.hpp"
#include "bench/hard/cell_process.hpp"
#include "bench/hard/fuzz.hpp"
#include "bench/hard/hard_case.hpp"
#include "bench/hard/hard_matrix.hpp"
#include "bench/process/progress.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

int usable_cores() {
  cpu_set_t allowed;
  return sched_getaffinity(0, sizeof(allowed), &allowed) == 0 ? std::max(1, CPU_COUNT(&allowed)) : 1;
}

struct HardOptions {
  std::vector<std::string> backends;
  std::vector<std::string> cases;
  std::vector<std::string> parameters;
  std::string out;
  std::string data;
  std::string wrong;
  double seconds = 0;
  int jobs = usable_cores();
  int fuzz = 0;
  std::uint64_t first_seed = 1;
  bool whole = false;
  bool list = false;
  bool progress_lines = false;
};

std::vector<const BackendEntry*> chosen_backends(const HardOptions& options) {
  std::vector<const BackendEntry*> chosen;
  for (const std::string& name : options.backends) chosen.push_back(&find_backend(name));
  if (chosen.empty()) {
    for (const BackendEntry& entry : backend_registry()) chosen.push_back(&entry);
  }
  return chosen;
}

std::vector<HardCase> chosen_cases(const HardOptions& options) {
  const std::vector<HardCase> all = hard_cases();
  if (options.cases.empty()) return all;
  std::vector<HardCase> chosen;
  for (const std::string& id : options.cases) {
    const auto found = std::ranges::find(all, id, &HardCase::id);
    if (found == all.end()) {
      std::vector<std::string> ids;
      for (const HardCase& each : all) ids.emplace_back(each.id);
      throw InputError("--case " + id,
                       fmt::format("is unknown; did you mean '{}'? --list shows all", nearest_word(id, ids)));
    }
    chosen.push_back(*found);
  }
  return chosen;
}

void print_cases(const std::vector<HardCase>& cases) {
  for (const HardCase& each : cases) {
    fmt::print("{}\n  {}\n  {}\n  Bar: {}.\n", each.id, each.what, each.why, each.bar);
    if (!each.left_out_because.empty()) fmt::print("  Sane figures left out: {}.\n", each.left_out_because);
    if (!each.scene.empty()) fmt::print("  Scene: {}\n", each.scene);
  }
}

/// Earlier files of the cell are removed.
std::string wrong_prefix(const HardOptions& options, const HardCase& each, const BackendEntry& backend) {
  if (options.wrong.empty()) return {};
  std::filesystem::create_directories(options.wrong);
  std::string prefix = (std::filesystem::path(options.wrong) / fmt::format("{}-{}", each.id, backend.name)).string();
  for (int number = 1; std::filesystem::remove(fmt::format("{}-{}.queries", prefix, number)); ++number) {
  }
  return prefix;
}

HardMatrix run_cells(const HardOptions& options) {
  const std::vector<const BackendEntry*> backends = chosen_backends(options);
  HardMatrix matrix{{}, chosen_cases(options)};
  for (const BackendEntry* entry : backends) matrix.backends.push_back(column_of(*entry));
  const int total = static_cast<int>(matrix.cases.size() * backends.size());
  Progress progress(progress_style(options.progress_lines), "hard cases", total);
  std::vector<HardCell> cells(static_cast<std::size_t>(total));
  std::deque<CellProcess> at_work;
  std::deque<std::size_t> cell_of;  // that is at work
  std::size_t started = 0;
  int done = 0;
  const auto take_one = [&] {
    const std::size_t ended = CellProcess::wait_for_any(at_work);
    cells[cell_of[ended]] = at_work[ended].result();
    at_work.erase(at_work.begin() + static_cast<std::ptrdiff_t>(ended));
    cell_of.erase(cell_of.begin() + static_cast<std::ptrdiff_t>(ended));
    progress.show(++done);
  };
  for (const HardCase& each : matrix.cases) {
    for (const BackendEntry* entry : backends) {
      const HardRequest request{.backend = *entry,
                                .given = parse_assignments(options.parameters, "--param", entry->parameters),
                                .whole = options.whole,
                                .data = options.data,
                                .threads = 1,
                                .wrong_prefix = wrong_prefix(options, each, *entry)};
      if (static_cast<int>(at_work.size()) >= options.jobs) take_one();
      at_work.emplace_back([&] { return each.run(request); }, options.seconds);
      cell_of.push_back(started++);
    }
  }
  while (!at_work.empty()) take_one();
  for (std::size_t first = 0; first < cells.size(); first += backends.size()) {
    const auto row = cells.begin() + static_cast<std::ptrdiff_t>(first);
    matrix.cells.emplace_back(row, row + static_cast<std::ptrdiff_t>(backends.size()));
  }
  return matrix;
}

std::string default_text(const std::string& text, const char* otherwise) { return text.empty() ? otherwise : text; }

/// What seeds draw from: part of the command that makes a scene again.
std::string named_backends(const HardOptions& options) {
  std::string text;
  for (const std::string& backend : options.backends) text += " --backend " + backend;
  return text;
}

/// Random scenes; what is wrong is made as small as it stays wrong, and written as a scene that `run` takes.
int run_fuzz(const HardOptions& options) {
  std::vector<std::string> backends;
  for (const BackendEntry* entry : chosen_backends(options)) backends.push_back(entry->name);
  std::map<std::string, int> counts;
  std::vector<std::string> wrong;
  {
    Progress progress(progress_style(options.progress_lines), "random scenes", options.fuzz);
    for (int i = 0; i < options.fuzz; ++i) {
      const FuzzScene scene = fuzz_scene(options.first_seed + static_cast<std::uint64_t>(i), backends);
      const FuzzOutcome outcome = run_fuzz_scene(scene, options.seconds);
      if (!outcome.wrong.empty()) {
        const std::filesystem::path folder =
            std::filesystem::path(default_text(options.out, "reports/out/fuzz")) / fmt::format("seed-{}", scene.seed);
        const FuzzScene smallest = shrunk(scene, options.seconds);
        write_fuzz_scene(smallest, folder);
        wrong.push_back(fmt::format(
            "seed {0}: {1}\n  musclebench hard --fuzz 1 --seed {0}{2}\n  as small as it gets: musclebench run {3} "
            "--backend {4}",
            scene.seed, outcome.wrong, named_backends(options), (folder / "scene.toml").string(), scene.backend));
      }
      ++counts[!outcome.wrong.empty() ? "wrong" : !outcome.refused.empty() ? "refused" : outcome.status];
      progress.show(i + 1);
    }
  }
  fmt::print("{} random scenes from seed {}:", options.fuzz, options.first_seed);
  for (const auto& [status, count] : counts) fmt::print(" {} {}", count, status);
  fmt::print("\n");
  for (const std::string& line : wrong) fmt::print("{}\n", line);
  return wrong.empty() ? 0 : exit_not_held;
}

int run_hard(HardOptions& options) {
  if (options.list) {
    print_cases(chosen_cases(options));
    return 0;
  }
  if (!options.parameters.empty()) {
    if (options.backends.size() != 1) {
      throw InputError("--param", "is of one backend; name it with --backend, and no other");
    }
    (void)backend_parameters(find_backend(options.backends.front()), options.parameters);
  }
  if (options.seconds == 0) options.seconds = options.whole ? 3600 : 300;
  if (options.fuzz > 0) {
    if (!options.cases.empty() || !options.parameters.empty()) {
      throw InputError("--fuzz", "makes its own scenes, with backends as they are; leave out --case and --param");
    }
    return run_fuzz(options);
  }
  const HardMatrix matrix = run_cells(options);
  fmt::print("{}", text_of(matrix));
  if (!options.out.empty()) {
    write_matrix(matrix, options.out);
    fmt::print("written: {0}/matrix.csv and {0}/matrix.md\n", options.out);
  }
  return matrix.count(Verdict::breaks) > 0 ? exit_not_held : 0;
}

}  // namespace

void add_hard_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<HardOptions>();
  CLI::App* command = app.add_subcommand(
      "hard", "Run the hard cases, which are numerically difficult scenes, with every backend, one process each");
  command->add_option("--backend", options->backends, "Run only this backend; may be repeated (default: all)");
  command->add_option("--case", options->cases, "Run only this case; may be repeated (default: all)");
  command->add_option("--param", options->parameters, "Parameter key=value of the one --backend; may be repeated");
  command->add_option("--data", options->data,
                      "Folder of the LHDL data, for the cases with real muscles (default: $MUSCLEBENCH_DATA)");
  command->add_option("--wrong-points", options->wrong,
                      "Folder for query sets of the points whose side a backend tells wrongly (default: none); "
                      "datasets/queries/README.md explains them");
  command->add_option("--out", options->out, "Folder for matrix.csv and matrix.md (default: none, print only)");
  command
      ->add_option("--seconds", options->seconds,
                   "Time after which a cell counts as hung, s (default: 300; with --all 3600)")
      ->check(positive_and_finite());
  command->add_option("--jobs", options->jobs, "Cells that run at the same time (default: one on each core)")
      ->check(CLI::Range(1, 1024));
  command
      ->add_option("--fuzz", options->fuzz,
                   "Run this many random scenes instead of the cases; shrink each failing scene and write it to --out "
                   "(default: reports/out/fuzz)")
      ->check(CLI::Range(1, 10'000'000));
  command
      ->add_option("--seed", options->first_seed, "Random seed of the first scene of --fuzz; the next scenes count up")
      ->capture_default_str();
  command->add_flag("--all", options->whole, "Also run the long sweeps: many minutes, hours with --data");
  command->add_flag("--list", options->list,
                    "Print what happens in each case, why it is hard and what its bar is; run nothing");
  command->add_flag("--progress", options->progress_lines, "Print progress as lines on standard error");
  command->footer(
      "Example: musclebench hard --case pinch --backend sdf\n"
      "A case has a bar: the result that a backend must reach. After each case, every muscle that moved must also be "
      "sane:\n"
      "  - No triangle passes through a bone, another muscle or its own muscle, unless it did at rest.\n"
      "  - No node is on the wrong side of a bone.\n"
      "  - The surface is at most 0.1 mm or 1 % of the muscle's diagonal deep in a bone, plus the backend's declared "
      "error.\n"
      "  - The volume changed by at most 5 %, and no edge is longer than twice its rest length.\n"
      "  - The status is ok.\n"
      "The column `loop` is the loop without contacts.\n"
      "Exit codes: 0 no cell breaks its bar, 1 a cell does, 2 bad input.");
  command->callback([options, &exit_code] { exit_code = run_hard(*options); });
}

}  // namespace musclebench

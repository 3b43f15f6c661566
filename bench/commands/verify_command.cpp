#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/cases/scene_source.hpp"
#include "bench/cases/verification.hpp"
#include "bench/commands/command_options.hpp"
#include "bench/commands/commands.hpp"
#include "bench/process/progress.hpp"
#include "bench/results/verification_json.hpp"

namespace musclebench {

namespace {

struct VerifyOptions {
  SceneChoice choice;
  VerificationSettings settings;
  bool progress_lines = false;
  bool json = false;
};

/// One bar a stage.
class StageProgress {
 public:
  StageProgress(Progress::Style style, std::string surface) : m_style(style), m_surface(std::move(surface)) {}

  void show(const std::string& stage, int done, int total) {
    if (!m_bar || stage != m_stage) {
      m_bar.reset();
      m_bar = std::make_unique<Progress>(m_style, m_surface + ": " + stage, total);
      m_stage = stage;
    }
    m_bar->show(done);
  }

 private:
  Progress::Style m_style;
  std::string m_surface;
  std::string m_stage;
  std::unique_ptr<Progress> m_bar;
};

void print_row(const std::string& bone, const char* surface, const Agreement& agreement,
               const SurfaceVerification& of) {
  const std::string pair = agreement.first + ", " + agreement.second;
  fmt::print("{:<12} {:<10} {:<21} {:>9} {:>9} {:>12.2e} {:>12} {:>9.1f}\n", bone, surface, pair, agreement.points,
             agreement.inside, agreement.largest_difference_m / of.diagonal_m, agreement.sign_differences, of.seconds);
  if (!of.holds(agreement)) {
    fmt::print("  worst at ({:.17g}, {:.17g}, {:.17g}) m\n", agreement.worst_point_m.x(), agreement.worst_point_m.y(),
               agreement.worst_point_m.z());
  }
}

SurfaceVerification verify(const Bone& bone, const char* surface, const VerifyOptions& options) {
  StageProgress progress(progress_style(options.progress_lines), fmt::format("{} {}", bone.name, surface));
  return verify_surface(bone, options.settings, [&](const auto&... work) { progress.show(work...); });
}

int verify_scene(const VerifyOptions& options) {
  const Scene scene = load_scene(options.choice);
  if (!options.json) {
    fmt::print("{:<12} {:<10} {:<21} {:>9} {:>9} {:>12} {:>12} {:>9}\n", "bone", "surface", "pair", "points", "inside",
               "difference", "signs differ", "seconds");
  }
  bool held = true;
  Json surfaces = Json::array();
  const auto take = [&](const Bone& bone, const char* surface) {
    const SurfaceVerification result = verify(bone, surface, options);
    held = result.held() && held;
    if (options.json) {
      surfaces.push_back(json_of(result, bone.name, surface));
      return;
    }
    for (const Agreement& pair : result.pairs) print_row(bone.name, surface, pair, result);
    std::fflush(stdout);
  };
  for (std::size_t i = 0; i < scene.bones.size(); ++i) {
    take(scene.bones[i], "repaired");
    take({scene.bones[i].name, {scene.bone_meshes[i].mesh, false, {}}}, "as shipped");
  }
  if (options.json) {
    fmt::print("{}\n", text_of({{"scene", scene.name}, {"held", held}, {"surfaces", surfaces}}, 2));
  } else {
    fmt::print(
        "difference: of the distances, as a share of the bone's diagonal; signs: of points farther than {:g} of it, "
        "and "
        "{:g} roundings of the largest coordinate, from the surface; seconds: of all\n{}\n",
        agreed_share, agreed_roundings, held ? "held" : "NOT held");
  }
  return held ? 0 : exit_not_held;
}

}  // namespace

void add_verify_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<VerifyOptions>();
  CLI::App* command = app.add_subcommand(
      "verify", "Compare the exact backends with the Referee around each bone of a scene, repaired and as shipped");
  command->footer(
      "Example: musclebench verify synthetic/iliacus --points 100000\n"
      "The Referee is the code that judges every run; it shares no code with the backends.\n"
      "Exit codes: 0 all agree, 1 they differ.");
  command->add_option("scene", options->choice.scene, "Scene: a name that `musclebench list` prints, or a .toml file")
      ->required();
  command
      ->add_option("--points", options->settings.points,
                   "Points around each surface, for the first exact backend and the Referee; an open surface gets 1/50")
      ->capture_default_str()
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1'000'000'000}));
  command
      ->add_option("--brute-force-points", options->settings.brute_force_points,
                   "How many of these points the slower exact backends also answer")
      ->capture_default_str()
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1'000'000'000}));
  command->add_option("--seed", options->settings.seed, "Random seed of the points")->capture_default_str();
  add_threads_option(*command, options->settings.threads);
  command->add_option("--data", options->choice.data, "Folder of the anatomical data (default: $MUSCLEBENCH_DATA)");
  command->add_flag("--json", options->json, "Print the rows as JSON at the end");
  command->add_flag("--progress", options->progress_lines, "Print progress as lines on standard error");
  command->callback([options, &exit_code] { exit_code = verify_scene(*options); });
}

}  // namespace musclebench

// Runs a small scene with every combination of the effects, 2^k of them, and looks whether all stay finite. Takes
// minutes; the tests run a part. Exit code 1 where one does not.
//   effect_combinations [--every N]
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bench/cases/build_backend.hpp"
#include "bench/cases/tests/combination_scene.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {
namespace {

constexpr int coarse = 1;         // of the balls
constexpr double farthest_m = 1;  // the scene has a few centimetres

std::vector<std::string> chosen_of(const std::vector<std::string>& names, std::uint64_t mask) {
  std::vector<std::string> chosen;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if ((mask >> i & 1U) != 0) chosen.push_back(names[i]);
  }
  return chosen;
}

/// Only the named ones of a scene of all.
Scene with_some(const Scene& all, const std::vector<std::string>& names) {
  Scene scene = all;
  std::erase_if(scene.effects,
                [&](const SceneEffect& effect) { return std::ranges::find(names, effect.name) == names.end(); });
  return scene;
}

/// What went wrong; empty where all nodes stay where a scene of this size has them.
std::string fault_of(const Scene& scene) {
  const RunCase run = combination_case(scene);
  const BuiltBackend built = build_backend(run);
  const PreparedSimulation prepared = prepare_simulation(scene, *built.backend, run.responses, run.threads,
                                                         make_contact_methods(scene, run.colliders, run.threads));
  for (int frame = 1; frame <= scene.loop.frames; ++frame) {
    prepared.simulation->step_frame(frame);
    for (const Vec3& position : prepared.simulation->positions()) {
      if (!position.allFinite() || position.norm() > farthest_m) {
        return fmt::format("frame {}: a node is at {:g} {:g} {:g} m", frame, position.x(), position.y(), position.z());
      }
    }
  }
  return "";
}

int run_combinations(std::uint64_t every) {
  std::vector<std::string> names;
  for (const EffectEntry& entry : effect_registry()) names.push_back(entry.name);
  const Scene all = combination_scene(names, coarse);
  const std::uint64_t count = std::uint64_t{1} << names.size();
  std::uint64_t done = 0;
  std::uint64_t faults = 0;
  for (std::uint64_t mask = 0; mask < count; mask += every) {
    const std::vector<std::string> chosen = chosen_of(names, mask);
    if (const std::string fault = fault_of(with_some(all, chosen)); !fault.empty()) {
      ++faults;
      fmt::print(stderr, "{}: {}\n", fmt::join(chosen, " + "), fault);
    }
    if (++done % 1000 == 0) fmt::print(stderr, "{} of {}\n", done, (count + every - 1) / every);
  }
  fmt::print("{} of {} combinations of {} effects: {}\n", done, count, names.size(),
             faults == 0 ? "all stay finite" : fmt::format("{} do not stay finite", faults));
  return faults == 0 ? 0 : 1;
}

}  // namespace
}  // namespace musclebench

int main(int argc, char** argv) {
  try {
    CLI::App app("Runs a small scene with every combination of the effects.");
    std::uint64_t every = 1;
    app.add_option("--every", every, "Only every so many-th combination")->check(CLI::Range(1, 1000000));
    CLI11_PARSE(app, argc, argv);
    return musclebench::run_combinations(every);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "effect_combinations: %s\n", error.what());
    return 2;
  }
}

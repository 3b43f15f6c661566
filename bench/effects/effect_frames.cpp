// Runs a small scene with the effects that are named and prints what absent_effects_test compares between programs.
//   effect_frames [--one-frame] [--without=contact|fibre_anisotropy|muscle_contact] [EFFECT...]
#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bench/cases/build_backend.hpp"
#include "bench/cases/tests/combination_scene.hpp"
#include "bench/process/heap_counter.hpp"
#include "core/base/input_error.hpp"
#include "core/base/sha256.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {
namespace {

constexpr int coarse = 1;  // the balls: instructions are counted by a program that is fifty times slower

/// All that effects are made for and do: where callgrind counts.
[[gnu::noinline]] PreparedSimulation counted_run(const RunCase& run, CollisionBackend& backend, int frames) {
  PreparedSimulation prepared = prepare_simulation(run.scene, backend, run.responses, run.threads,
                                                   make_contact_methods(run.scene, run.colliders, run.threads));
  for (int frame = 1; frame <= frames; ++frame) prepared.simulation->step_frame(frame);
  return prepared;
}

std::string trajectory_hash(const Simulation& simulation) {
  Sha256 hash;
  hash.add(std::as_bytes(std::span(simulation.positions())));
  hash.add(std::as_bytes(std::span<const Vec3>(simulation.velocities())));
  return hash.hex_digest();
}

const BackendEntry& backend_without_contacts() {
  return *std::ranges::find_if(backend_registry(), [](const BackendEntry& entry) {
    return !entry.make(Parameters(entry.parameters, {}, entry.name))->capabilities().finds_contacts;
  });
}

void run_and_print(std::vector<std::string> arguments) {
  const bool one_frame = std::erase(arguments, "--one-frame") > 0;
  const auto leaves_out = [&](const char* effect) {
    return std::erase(arguments, fmt::format("--without={}", effect)) > 0;
  };
  const bool no_contact = leaves_out("contact");
  const bool no_fibres = leaves_out("fibre_anisotropy");
  const bool no_muscle_contact = leaves_out("muscle_contact");
  Scene scene = combination_scene(arguments, coarse);
  if (no_fibres) scene.muscles[0].fibres.clear();
  if (no_muscle_contact) scene.muscle_pairs.clear();
  const RunCase run = combination_case(scene, no_contact ? backend_without_contacts() : exact_backend());
  const BuiltBackend built = build_backend(run);
  const HeapUse before = heap_use();
  PreparedSimulation prepared;
  // A thread has an arena of its own. How long malloc searches depends on what was freed before, and what the table of
  // effects frees differs between programs.
  std::thread([&] { prepared = counted_run(run, *built.backend, one_frame ? 1 : scene.loop.frames); }).join();
  const HeapUse after = heap_use();
  std::vector<std::string> columns = prepared.effect_names;
  columns.insert(columns.end(), prepared.stage_names.begin(), prepared.stage_names.end());
  fmt::print("state {}\nallocations {}\nbytes {}\ncolumns {}\n", trajectory_hash(*prepared.simulation),
             after.allocations - before.allocations, after.bytes - before.bytes, fmt::join(columns, " "));
}

}  // namespace
}  // namespace musclebench

int main(int argc, char** argv) {
  try {
    musclebench::run_and_print({argv + 1, argv + argc});
  } catch (const musclebench::InputError& error) {
    fmt::print(stderr, "effect_frames: {}\n", error.what());
    return 2;
  }
  return 0;
}

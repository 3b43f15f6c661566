// A frame after the second allocates nothing: what frames need is made before the first, or grows in the first two.
// Not asked of fcl, whose library allocates in every query, nor of brute_force, which is there to be right.
#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bench/cases/build_backend.hpp"
#include "bench/cases/scene_source.hpp"
#include "bench/process/heap_counter.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {
namespace {

/// A third of the motion there and back, in few frames: the contacts come late and are many.
Scene bending_scene() { return load_scene({"synthetic/adductor_brevis", "paper", "", {{"frames", std::int64_t{16}}}}); }

struct Choice {
  std::string backend;
  ResponseKind response;
  std::map<std::string, ParameterValue> parameters;
  int threads = 1;
};

/// Allocations of each frame from the third on.
std::vector<std::uint64_t> allocations_of_frames(const Scene& scene, const Choice& choice,
                                                 CollisionObserver* observer) {
  const BackendEntry& backend = find_backend(choice.backend);
  const Case resolved{scene,          backend, Parameters(backend.parameters, choice.parameters, backend.name),
                      choice.threads, 0,       {choice.response}};
  const BuiltBackend built = build_backend(resolved);
  const PreparedSimulation prepared =
      prepare_simulation(resolved.scene, *built.backend, resolved.responses, resolved.threads);
  std::vector<std::uint64_t> counts;
  std::size_t most_contacts = 0;
  std::size_t early_contacts = 0;
  for (int frame = 1; frame <= scene.loop.frames; ++frame) {
    const std::uint64_t before = heap_allocations();
    prepared.simulation->step_frame(frame, observer);
    const std::uint64_t after = heap_allocations();
    most_contacts = std::max(most_contacts, prepared.simulation->contacts().size());
    if (frame > 2) {
      counts.push_back(after - before);
    } else {
      early_contacts = most_contacts;
    }
  }
  if (backend.name != "null") {
    EXPECT_GT(most_contacts, early_contacts) << "the scene does not ask for more memory as it goes on";
  }
  return counts;
}

/// Once for all backends: reading the scene takes longer than running it.
TEST(AFrameAfterTheSecond, AllocatesNothing) {
  const std::map<std::string, ParameterValue> few_cells{{"cells", std::int64_t{16}}};
  const std::vector<Choice> choices{{"null", ResponseKind::project, {}},
                                    {"voxel", ResponseKind::backtrack, {}},
                                    {"sdf", ResponseKind::project, few_cells},
                                    {"sdf", ResponseKind::backtrack, few_cells},
                                    {"sdf", ResponseKind::project, few_cells, 2},
                                    {"sdf", ResponseKind::project, {{"max_error_mm", 1.0}}},
                                    {"sdf", ResponseKind::project, {{"max_error_mm", 1.0}}, 2},
                                    {"bvh", ResponseKind::project, {}},
                                    {"bvh", ResponseKind::project, {}, 2}};
  const Scene scene = bending_scene();
  const int most_threads = each_parallel_region_allocates ? 1 : 2;
  for (const Choice& choice : choices) {
    if (choice.threads > most_threads) continue;
    SCOPED_TRACE(choice.backend + (choice.response == ResponseKind::project ? ", project" : ", backtrack") +
                 (choice.threads > 1 ? ", threads" : ""));
    const auto counts = allocations_of_frames(scene, choice, nullptr);
    EXPECT_EQ(counts, std::vector<std::uint64_t>(counts.size(), 0));
  }
  LastDetection last;
  Choice observed_choice = choices.back();
  observed_choice.threads = most_threads;
  const auto observed = allocations_of_frames(scene, observed_choice, &last);
  EXPECT_EQ(observed, std::vector<std::uint64_t>(observed.size(), 0));
}

TEST(HeapCounter, SeesWhatAnotherLibraryAllocates) {
  const std::uint64_t before = heap_allocations();
  const std::string text(100, 'x');
  EXPECT_STREQ(text.c_str() + 99, "x");  // clang leaves out what nobody looks at
  EXPECT_GE(heap_allocations() - before, 1U);
}

}  // namespace
}  // namespace musclebench

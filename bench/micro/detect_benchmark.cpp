// One detection of each backend on fixed nodes: the iliacus pushed towards the bones, so that some of it is inside.
// Reports items (nodes) a second and the bytes of the structures. The scene is synthetic/iliacus, or the one in
// MUSCLEBENCH_MICRO_SCENE.
#include <cstdlib>
#include <map>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "backends/registry.hpp"
#include "bench/scene_source.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {
namespace {

struct Nodes {
  Scene scene;
  std::vector<Vec3> positions;
  std::vector<int> all;
  std::vector<RigidMotion> poses;
};

/// The muscle at rest, the moving bone turned by 20 degrees into it.
const Nodes& nodes() {
  static const Nodes made = [] {
    const char* name = std::getenv("MUSCLEBENCH_MICRO_SCENE");
    Nodes n{load_scene({name != nullptr ? name : "synthetic/iliacus", "", "", {}}), {}, {}, {}};
    n.positions = n.scene.muscle.mesh.vertices;
    for (std::size_t i = 0; i < n.positions.size(); ++i) {
      n.all.push_back(static_cast<int>(i));
    }
    n.scene.poses_at(n.scene.loop.frames / 9.0, n.poses);
    return n;
  }();
  return made;
}

CollisionBackend& built_backend(const BackendEntry& entry) {
  static std::map<std::string, std::unique_ptr<CollisionBackend>> backends;
  std::unique_ptr<CollisionBackend>& backend = backends[entry.name];
  if (backend == nullptr) {
    backend = entry.make(Parameters(entry.parameters, {}, entry.name));
    backend->build(nodes().scene.bones, nodes().scene.muscle.mesh, 1);
  }
  return *backend;
}

void report(benchmark::State& state, const CollisionBackend& backend, std::size_t contacts) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(nodes().all.size()));
  state.counters["structure_bytes"] = static_cast<double>(backend.structure_bytes());
  state.counters["contacts"] = static_cast<double>(contacts);
}

void detect(benchmark::State& state, const BackendEntry& entry) {
  CollisionBackend& backend = built_backend(entry);
  std::vector<Contact> contacts;
  backend.update(nodes().poses, nodes().positions);
  for (auto _ : state) {
    backend.detect(nodes().positions, nodes().all, contacts);
    benchmark::DoNotOptimize(contacts.data());
  }
  report(state, backend, contacts.size());
}

void update(benchmark::State& state, const BackendEntry& entry) {
  CollisionBackend& backend = built_backend(entry);
  for (auto _ : state) {
    backend.update(nodes().poses, nodes().positions);
  }
  report(state, backend, 0);
}

}  // namespace
}  // namespace musclebench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
    return 2;
  }
  try {
    for (const musclebench::BackendEntry& entry : musclebench::backend_registry()) {
      for (const auto& [kernel, function] :
           {std::pair("update", &musclebench::update), std::pair("detect", &musclebench::detect)}) {
        auto* registered = benchmark::RegisterBenchmark(fmt::format("{}/{}", kernel, entry.name).c_str(),
                                                        [&entry, f = function](benchmark::State& s) { f(s, entry); });
        registered->Unit(benchmark::kMicrosecond);
        if (entry.name == "brute_force") {
          registered->Iterations(1);  // takes a minute on real anatomy
        }
      }
    }
    benchmark::RunSpecifiedBenchmarks();
  } catch (const musclebench::InputError& error) {
    fmt::print(stderr, "musclebench_micro: {}\n", error.what());
    return 2;
  }
  benchmark::Shutdown();
  return 0;
}

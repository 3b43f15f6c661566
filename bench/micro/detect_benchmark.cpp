// One detection of each backend on fixed nodes: the muscle at rest, the moving bone turned by 20 degrees into it, so
// that some of it is inside. Reports items (nodes) a second and the bytes of the structures.
#include <map>
#include <numeric>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "bench/micro/micro_kernels.hpp"
#include "bench/micro/micro_scene.hpp"
#include "core/base/huge_pages.hpp"

namespace musclebench {
namespace {

/// Once is enough of what takes longer.
constexpr double long_step_ms = 1000;

struct Nodes {
  std::vector<Vec3> positions;
  std::vector<int> all;
  std::vector<RigidMotion> poses;
};

const Nodes& nodes() {
  static const Nodes made = [] {
    const Scene& scene = micro_scene();
    Nodes n{scene.muscle_mesh.vertices, std::vector<int>(scene.muscle_mesh.vertices.size()), {}};
    std::iota(n.all.begin(), n.all.end(), 0);
    scene.poses_at(scene.loop.frames / 9.0, n.poses);
    return n;
  }();
  return made;
}

CollisionBackend& kept_backend(const std::string& name, int threads) {
  static std::map<std::pair<std::string, int>, std::unique_ptr<CollisionBackend>> backends;
  std::unique_ptr<CollisionBackend>& backend = backends[{name, threads}];
  if (backend == nullptr) {
    const Scene& scene = micro_scene();
    backend = built_backend(name, cold_settings(name), scene.bones, scene.muscle_mesh, threads);
  }
  return *backend;
}

void report(benchmark::State& state, const CollisionBackend& backend, std::size_t contacts) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(nodes().all.size()));
  state.counters["structure_bytes"] = static_cast<double>(backend.structure_bytes());
  state.counters["contacts"] = static_cast<double>(contacts);
}

void detect(benchmark::State& state, const std::string& name, int threads) {
  CollisionBackend& backend = kept_backend(name, threads);
  std::vector<Contact> contacts;
  backend.update(nodes().poses, nodes().positions);
  move_to_huge_pages();
  for (auto _ : state) {
    backend.detect(nodes().positions, nodes().all, contacts);
    benchmark::DoNotOptimize(contacts.data());
  }
  report(state, backend, contacts.size());
}

void update(benchmark::State& state, const std::string& name) {
  CollisionBackend& backend = kept_backend(name, 1);
  for (auto _ : state) {
    backend.update(nodes().poses, nodes().positions);
  }
  report(state, backend, 0);
}

}  // namespace

void register_detect_kernels() {
  for (const BackendEntry& entry : backend_registry()) {
    benchmark::RegisterBenchmark(("update/" + entry.name).c_str(), [name = entry.name](benchmark::State& s) {
      update(s, name);
    })->Unit(benchmark::kMicrosecond);
    auto* detection = benchmark::RegisterBenchmark(("detect/" + entry.name).c_str(),
                                                   [name = entry.name](benchmark::State& s) { detect(s, name, 1); });
    detection->Unit(benchmark::kMicrosecond);
    if (guessed_step_ms(entry) > long_step_ms) {
      detection->Iterations(1);
    }
  }
  for (const std::string& name : raced_backends()) {
    if (find_parameter(find_backend(name).parameters, ParameterRole::clearance_cache) == nullptr) {
      continue;  // too little work for threads
    }
    benchmark::RegisterBenchmark(("detect_threads/" + name).c_str(),
                                 [name](benchmark::State& s) { detect(s, name, static_cast<int>(s.range(0))); })
        ->Arg(1)
        ->Arg(2)
        ->UseRealTime()
        ->Unit(benchmark::kMicrosecond);
  }
}

}  // namespace musclebench

// What a node of the distance field costs to build, against one exact closest-point query of the Referee near the
// surface; and how the build scales with threads. The bone is the first of synthetic/iliacus, or of the scene in
// MUSCLEBENCH_MICRO_SCENE.
#include <cstdlib>
#include <random>

#include <benchmark/benchmark.h>

#include "backends/sdf/field_builder.hpp"
#include "bench/scene_source.hpp"
#include "core/measure/referee.hpp"

namespace musclebench {
namespace {

constexpr int cells = 64;

const Scene& scene() {
  static const Scene loaded = [] {
    const char* name = std::getenv("MUSCLEBENCH_MICRO_SCENE");
    return load_scene({name != nullptr ? name : "synthetic/iliacus", "", "", {}});
  }();
  return loaded;
}

void sdf_build_a_node(benchmark::State& state) {
  const Bone& bone = scene().bones.front();
  const SignedSurface surface(bone.surface);
  const GridShape shape = grid_over(bone.surface.mesh, {.cells = cells}, bone.name);
  std::size_t bytes = 0;
  for (auto _ : state) {
    const CubicField field =
        build_field(surface, shape, FieldPrecision::single_precision, static_cast<int>(state.range(0)));
    bytes = field.bytes();
  }
  const auto nodes = static_cast<double>(shape.node_count());
  state.counters["ns_a_node"] =
      benchmark::Counter(nodes * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["structure_bytes"] = static_cast<double>(bytes);
}
BENCHMARK(sdf_build_a_node)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

/// One exact closest point with sign, at vertices of `mesh` jittered by 2 mm.
void referee_query(benchmark::State& state, const TriangleMesh& mesh) {
  const Referee referee(scene().bones, 0);
  std::mt19937 random(1);
  std::normal_distribution<double> jitter(0, 0.002);
  std::vector<Vec3> points;
  const std::size_t step = std::max<std::size_t>(1, mesh.vertices.size() / 20000);
  for (std::size_t i = 0; i < mesh.vertices.size(); i += step) {
    points.push_back(mesh.vertices[i] + Vec3(jitter(random), jitter(random), jitter(random)));
  }
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(referee.closest(0, points[next]).signed_distance_m);
    next = next + 1 < points.size() ? next + 1 : 0;
  }
}

/// Where the queries of a run are.
void referee_query_at_muscle(benchmark::State& state) { referee_query(state, scene().muscle.mesh); }
BENCHMARK(referee_query_at_muscle);

void referee_query_at_bone(benchmark::State& state) { referee_query(state, scene().bones.front().surface.mesh); }
BENCHMARK(referee_query_at_bone);

}  // namespace
}  // namespace musclebench

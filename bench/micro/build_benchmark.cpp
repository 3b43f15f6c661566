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

/// Vertices of the muscle and of the bone, jittered by 2 mm: as near to the surface as nodes come.
void referee_query_near(benchmark::State& state) {
  const Bone& bone = scene().bones.front();
  const Referee referee(scene().bones, 0);
  std::mt19937 random(1);
  std::normal_distribution<double> jitter(0, 0.002);
  std::vector<Vec3> points;
  const auto& vertices = bone.surface.mesh.vertices;
  for (std::size_t i = 0; i < vertices.size(); i += std::max<std::size_t>(1, vertices.size() / 20000)) {
    points.push_back(vertices[i] + Vec3(jitter(random), jitter(random), jitter(random)));
  }
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(referee.closest(0, points[next]).signed_distance_m);
    next = next + 1 < points.size() ? next + 1 : 0;
  }
}
BENCHMARK(referee_query_near);

}  // namespace
}  // namespace musclebench

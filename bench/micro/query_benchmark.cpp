// What one query of the exact closest point with its sign costs, without memory of any query before it. On the same
// points as those of backends, in the order of the muscle's vertices.
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "backends/micro/point_kernels.hpp"
#include "bench/micro/micro_kernels.hpp"
#include "bench/micro/micro_scene.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {
namespace {

void bvh_locate(benchmark::State& state, const Bone& bone, const std::vector<Vec3>& points) {
  const SignedSurface& surface = surface_of(bone);
  ask(state, points, [&](const Vec3& point) { return surface.locate(point).signed_distance_m(); });
}

}  // namespace

void register_query_kernels() {
  const auto add = [](const std::string& name, auto kernel) {
    benchmark::RegisterBenchmark(name.c_str(), kernel)->Unit(benchmark::kMicrosecond);
  };
  const Scene& scene = micro_scene();
  for (const Bone& bone : scene.bones) {
    add("bvh_locate/near/" + bone.name,
        [&scene, &bone](benchmark::State& s) { bvh_locate(s, bone, points_near(scene, bone, point_count)); });
    add("bvh_locate/far/" + bone.name,
        [&bone](benchmark::State& s) { bvh_locate(s, bone, points_far(bone, point_count)); });
  }
}

}  // namespace musclebench

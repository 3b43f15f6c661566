#include "bench/micro/scalar_loop.hpp"

#include <tuple>

#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "bench/cases/scene_source.hpp"

namespace musclebench {
namespace {

constexpr int frames = 8;

class ScalarLoopTest : public testing::TestWithParam<std::tuple<std::string, std::string>> {};

/// The whole loop over SIMD lanes against the same loop over scalar constraints: they differ by rounding only.
TEST_P(ScalarLoopTest, AgreesWithTheSimulation) {
  const auto& [preset, backend_name] = GetParam();
  const Scene scene = load_scene({"synthetic/adductor_brevis", preset, "", {{"frames", std::int64_t{40}}}});
  const BackendEntry& entry = find_backend(backend_name);
  const auto built = [&] {
    auto backend = entry.make(Parameters(entry.parameters, {}, "test"));
    backend->build(scene.bones, scene.muscle_mesh, 1);
    return backend;
  };
  const auto of_lanes = built();
  const auto of_scalars = built();
  const PreparedSimulation prepared = prepare_simulation(scene, *of_lanes, {entry.default_response}, 2);
  ScalarLoop loop(scene, *of_scalars, entry.default_response);
  double moved_m = 0;
  std::size_t contacts = 0;
  for (int frame = 1; frame <= frames; ++frame) {
    prepared.simulation->step_frame(frame);
    loop.step_frame(frame);
    contacts += prepared.simulation->contacts().size();
    for (std::size_t node = 0; node < loop.positions().size(); ++node) {
      const Vec3& expected = loop.positions()[node];
      ASSERT_LT((prepared.simulation->positions()[node] - expected).norm(), 1e-10) << "frame " << frame;
      moved_m = std::max(moved_m, (expected - scene.muscle_mesh.vertices[node]).norm());
    }
  }
  EXPECT_GT(moved_m, 1e-3);
  EXPECT_GT(contacts, 0U);
}

INSTANTIATE_TEST_SUITE_P(Presets, ScalarLoopTest,
                         testing::Combine(testing::Values("paper", "standard"), testing::Values("bvh", "voxel")),
                         [](const auto& named) { return std::get<0>(named.param) + "_" + std::get<1>(named.param); });

}  // namespace
}  // namespace musclebench

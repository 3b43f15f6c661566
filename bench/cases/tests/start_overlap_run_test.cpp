// What overlaps as a run begins is laid out and not thrown, whatever lays it out.
#include <string>

#include <gtest/gtest.h>

#include "bench/cases/build_backend.hpp"
#include "bench/cases/collider_backends.hpp"
#include "core/mesh/shapes.hpp"
#include "core/scene/muscle_contact.hpp"
#include "core/scene/prepare_simulation.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {
namespace {

constexpr double plate_top_m = 0.005;
constexpr double ball_radius_m = 0.012;
constexpr double slowly_m_per_s = 0.05;

TriangleMesh lifted(TriangleMesh mesh, const Vec3& by) {
  for (Vec3& vertex : mesh.vertices) vertex += by;
  return mesh;
}

/// A ball whose lowest node is `gap_m` above a plate; nothing moves but by contact.
struct Overlap {
  std::string name;
  std::string backend;
  std::string response;
  std::string more;
  double gap_m = 0;
  double other_gap_m = 0.1;  ///< of another ball beside it
  double depenetration_m_per_s = slowly_m_per_s;
};

std::ostream& operator<<(std::ostream& out, const Overlap& overlap) { return out << overlap.name; }

Scene scene_of(const Overlap& overlap) {
  SceneRequest request;
  request.name = request.file = "overlap.toml";
  request.synthetic_mesh = [&](const std::string& name) {
    if (name == "plate") return make_box(Vec3(0.1, 0.03, plate_top_m), 10);
    const double height_m = plate_top_m + ball_radius_m + overlap.gap_m;
    if (name == "ball") return lifted(make_sphere(ball_radius_m, 2), Vec3(0, 0, height_m));
    return lifted(make_sphere(ball_radius_m, 2),
                  Vec3(2 * ball_radius_m + overlap.other_gap_m, 0, plate_top_m + ball_radius_m + 0.05));
  };
  request.text =
      "[loop]\nframes = 10\nsubsteps = 20\ntime_step_s = 1e-3\ndensity_kg_per_m3 = 1000.0\ndepenetration_m_per_s = " +
      std::to_string(overlap.depenetration_m_per_s) +
      "\n[[bone]]\nname = \"plate\"\nmesh = \"synthetic:plate\"\n"
      "[[muscle]]\nname = \"ball\"\nmesh = \"synthetic:ball\"\n" +
      overlap.more;
  return read_scene(request);
}

struct Ended {
  double energy_j = 0;
  double slow_j = 0;    ///< of all its mass at the speed of depenetration
  double lowest_m = 1;  ///< node over the plate
};

Ended run(const Overlap& overlap) {
  const Scene scene = scene_of(overlap);
  const BackendEntry& entry = find_backend(overlap.backend);
  const Parameters parameters(entry.parameters, {}, "test");
  const ColliderBackends colliders = choose_collider_backends({}, scene, entry);
  const auto backend = make_backend(scene, entry, parameters, colliders);
  backend->build(scene.bones, scene.muscle_mesh, 1);
  const PreparedSimulation prepared =
      prepare_simulation(scene, *backend, choose_responses(overlap.response, scene, entry, parameters, colliders), 1,
                         make_contact_methods(scene, colliders, 1));
  Ended ended;
  for (int frame = 1; frame <= scene.loop.frames; ++frame) prepared.simulation->step_frame(frame);
  const std::vector<Vec3> velocities = prepared.simulation->velocities();
  for (std::size_t node = 0; node < velocities.size(); ++node) {
    const Muscle& muscle = scene.muscles[body_of(scene.bodies(), static_cast<int>(node))];
    ended.energy_j += 0.5 * node_mass_kg(scene, muscle) * velocities[node].squaredNorm();
    ended.slow_j += 0.5 * node_mass_kg(scene, muscle) * slowly_m_per_s * slowly_m_per_s;
  }
  for (const Vec3& position : prepared.simulation->positions()) {
    ended.lowest_m = std::min(ended.lowest_m, position.z() - plate_top_m);
  }
  return ended;
}

class StartOverlapRun : public testing::TestWithParam<Overlap> {};

TEST_P(StartOverlapRun, TakesUpNoSpeed) {
  Overlap apart = GetParam();
  apart.gap_m = apart.other_gap_m = 0.02;
  const Ended without = run(apart);
  const Ended with = run(GetParam());
  EXPECT_LT(without.energy_j, 1e-9 * with.slow_j);
  EXPECT_LE(with.energy_j, without.energy_j + 1e-6 * with.slow_j);
}

/// Ten frames of 20 ms are enough for 2 mm at 50 mm/s. Edges give back, as a speed, what strained them meanwhile.
TEST(StartOverlapEnd, IsOutAfterwardsAndThrownWithoutALimit) {
  Overlap overlap{"bone", "bvh", "project", "[effects.edge_length]\n[effects.volume]\n", -0.002};
  const Ended slow = run(overlap);
  EXPECT_GT(slow.lowest_m, -1e-6);
  overlap.depenetration_m_per_s = 0;
  EXPECT_LE(slow.energy_j, 2 * slow.slow_j);
  EXPECT_GT(run(overlap).energy_j, 3 * slow.slow_j);
}

constexpr const char* other =
    "[[muscle]]\nname = \"other\"\nmesh = \"synthetic:other\"\n[contact]\nmuscle_contact = true\n";
const std::string margin = "[effects.margin]\nthickness_m = 0.002\n";

INSTANTIATE_TEST_SUITE_P(
    Overlaps, StartOverlapRun,
    testing::Values(Overlap{"bone_push", "bvh", "project", "", -0.002},
                    Overlap{"bone_back", "voxel", "backtrack", "", -0.002},
                    Overlap{"bone_field", "sdf", "project", "", -0.002},
                    Overlap{"bones_at_once", "bvh", "project", "[effects.multi_bone]\n", -0.002},
                    Overlap{"margin", "bvh", "project", margin, 0.0001},
                    Overlap{"margin_and_bone", "bvh", "project", margin, -0.001},
                    Overlap{"margin_at_once", "bvh", "project", margin + "[effects.multi_bone]\n", 0.0001},
                    Overlap{"friction", "bvh", "project", "[effects.friction]\n", -0.002},
                    Overlap{"guard", "bvh", "project", "[effects.tunnelling_guard]\n", -0.002},
                    Overlap{"faces", "null", "project", "[effects.surface_contact]\n", -0.002},
                    Overlap{"nodes_and_faces", "bvh", "project", "[effects.surface_contact]\n", -0.002},
                    Overlap{"muscles", "bvh", "project", other, 0.05, -0.002}),
    [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace musclebench

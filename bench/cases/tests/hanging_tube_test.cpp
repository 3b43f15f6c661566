#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "bench/cases/run_case.hpp"
#include "core/mesh/shapes.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {
namespace {

/// What an effect is to be on every mesh: a closed tube, 0.2 m long, that hangs by its upper end under its weight and
/// becomes a third longer.
constexpr double length_m = 0.2;
constexpr double tube_radius_m = 0.02;

/// Rings of `around` vertices, each turned by half a step against the one above. Every mesh has the cross-section of
/// the round tube, so that all weigh the same.
TriangleMesh tube(int around, int rings) {
  constexpr double turn = 2 * std::numbers::pi;
  const double corner_m = tube_radius_m * std::sqrt(turn / around / std::sin(turn / around));
  TriangleMesh mesh;
  for (int ring = 0; ring < rings; ++ring) {
    for (int i = 0; i < around; ++i) {
      const double angle = turn * (i + 0.5 * ring) / around;
      mesh.vertices.emplace_back(corner_m * std::cos(angle), corner_m * std::sin(angle),
                                 length_m * (1 - static_cast<double>(ring) / (rings - 1)));
    }
  }
  mesh.vertices.emplace_back(0, 0, length_m);
  mesh.vertices.emplace_back(0, 0, 0);
  const int top = around * rings;
  const int last = top - around;
  for (int i = 0; i < around; ++i) {
    const int next = (i + 1) % around;
    mesh.triangles.push_back({top, i, next});
    mesh.triangles.push_back({last + i, top + 1, last + next});
    for (int above = 0; above < last; above += around) {
      const int below = above + around;
      mesh.triangles.push_back({above + i, below + i, above + next});
      mesh.triangles.push_back({above + next, below + i, below + next});
    }
  }
  return mesh;
}

struct Stiffness {
  bool is_per_area = false;
  int split = 0;
};

/// Its length at rest under its weight, over that without.
double stretch_of(const TriangleMesh& mesh, const Stiffness& stiffness) {
  const std::string per_area = stiffness.is_per_area ? "per_area = true\n" : "";
  SceneRequest request;
  request.name = "tube";
  request.file = "tube.toml";
  request.text = R"(
[loop]
frames = 100
substeps = 40
time_step_s = 5e-4
density_kg_per_m3 = 1060.0
[meshes]
split_muscles = )" +
                 std::to_string(stiffness.split) + R"(
[effects.gravity]
[effects.damping]
rate_per_s = 10.0
[effects.attachment]
[effects.volume]
[effects.edge_length]
compliance_m_per_n = 0.05
)" + per_area + R"([effects.bending]
stiffness = 1.0
compliance_rad_per_n_m = 1e4
)" + per_area + R"([[bone]]
name = "plate"
mesh = "synthetic:plate"
[muscle]
name = "tube"
mesh = "synthetic:tube"
[[attachment]]
name = "top"
bone = "plate"
near = "outline"
outline_m = [[-0.03, -0.03, 0.2], [0.03, -0.03, 0.2], [0.03, 0.03, 0.2], [-0.03, 0.03, 0.2]]
distance_m = 0.001
)";
  request.synthetic_mesh = [&](const std::string& name) {
    if (name == "tube") return mesh;
    TriangleMesh plate = make_box(Vec3(0.04, 0.04, 0.01), 1);
    for (Vec3& vertex : plate.vertices) vertex.z() += length_m + 0.02;
    return plate;
  };
  const BackendEntry& backend = find_backend("null");
  RunCase run{{read_scene(request), backend, Parameters(backend.parameters, {}, backend.name)}};
  run.judge = false;
  run.snapshots = {100};
  const RunResult result = run_case(run, [](int) {});
  EXPECT_EQ(result.status, "ok") << result.status_detail;
  double lowest_m = 0;
  for (const Vec3& position : result.snapshots.back().positions) lowest_m = std::min(lowest_m, position.z());
  return (length_m - lowest_m) / length_m;
}

double spread(const std::vector<double>& values) {
  const auto [least, most] = std::ranges::minmax(values);
  return most / least - 1;
}

TEST(HangingTube, ACompliancePerAreaStretchesEveryMeshAlike) {
  const std::vector<TriangleMesh> meshes = {tube(10, 15), tube(16, 25), tube(26, 43)};
  std::vector<double> per_area, per_edge;
  for (const TriangleMesh& mesh : meshes) {
    per_area.push_back(stretch_of(mesh, {.is_per_area = true}));
    per_edge.push_back(stretch_of(mesh, {.is_per_area = false}));
  }
  EXPECT_GT(per_area.front(), 1.3);
  EXPECT_LT(spread(per_area), 0.02);
  EXPECT_GT(spread(per_edge), 1.5 * spread(per_area));
}

TEST(HangingTube, SplitTrianglesStretchAsBefore) {
  // Springs of a sheet have its stiffness whatever their length.
  for (const bool is_per_area : {false, true}) {
    EXPECT_LT(spread({stretch_of(tube(10, 15), {is_per_area}), stretch_of(tube(10, 15), {is_per_area, 1})}), 0.01);
  }
}

}  // namespace
}  // namespace musclebench

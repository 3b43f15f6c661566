#include <gtest/gtest.h>

#include "core/mesh/tests/lhdl_data.hpp"
#include "core/mesh_files/read_mesh.hpp"
#include "core/referee/referee.hpp"
#include "core/referee/tests/naive_truth.hpp"

namespace musclebench {
namespace {

std::vector<Bone> repaired(const std::string& name) {
  const TriangleMesh mesh = read_mesh(*lhdl_folder() / "meshes" / (name + ".ply"));
  return {{name, repair_mesh(mesh, name)}};
}

/// Distances at `count` points near and `count` points around; every `every`-th also by its sign.
void expect_exact(const std::vector<Bone>& bones, int count, std::size_t every) {
  const TriangleMesh& mesh = bones[0].surface.mesh;
  const Referee referee(bones, 0);
  const double tolerance = 1e-12 * naive::diagonal(mesh);
  std::mt19937_64 random(1);
  std::vector<Vec3> points = naive::near_surface(mesh, count, 2e-3, random);
  for (const Vec3& point : naive::cloud(mesh, count, random)) points.push_back(point);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double found = referee.signed_distance(0, points[i]);
    const double size = naive::distance(mesh, points[i]);
    ASSERT_NEAR(std::abs(found), size, tolerance) << points[i].transpose();
    if (i % every != 0 || size <= tolerance) continue;
    ASSERT_EQ(found<0, naive::winding_number(mesh, points[i])> 0.5) << points[i].transpose();
  }
}

/// No vertex and no middle of an edge has a distance beyond rounding.
void expect_zero_on_surface(const std::vector<Bone>& bones) {
  const TriangleMesh& mesh = bones[0].surface.mesh;
  const Referee referee(bones, 0);
  for (const Vec3& vertex : mesh.vertices) ASSERT_EQ(referee.signed_distance(0, vertex), 0);
  const double tolerance = 1e-15 * naive::diagonal(mesh);
  for (const Vec3& point : naive::edge_midpoints(mesh)) ASSERT_NEAR(referee.signed_distance(0, point), 0, tolerance);
}

class RefereeOnLhdl : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!lhdl_folder()) GTEST_SKIP() << "the LHDL data are not there; set MUSCLEBENCH_DATA to their folder";
  }
};

TEST_P(RefereeOnLhdl, IsClosedAfterRepair) {
  const std::vector<Bone> bones = repaired(GetParam());
  EXPECT_TRUE(RefereeTree(bones[0].surface.mesh).closed());
}

TEST_P(RefereeOnLhdl, AgreesWithAllTriangles) {
  expect_exact(repaired(GetParam()), GetParam() == "pelvis" ? 400 : 1000, 40);
}

TEST_P(RefereeOnLhdl, IsZeroOnTheSurface) { expect_zero_on_surface(repaired(GetParam())); }

INSTANTIATE_TEST_SUITE_P(Bones, RefereeOnLhdl, testing::Values("femur_r", "pelvis"),
                         [](const auto& parameter) { return parameter.param; });

}  // namespace
}  // namespace musclebench

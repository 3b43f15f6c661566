#include "core/bvh/batch/batched_closest_point.hpp"

#include <cmath>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "core/bvh/tests/closest_by_brute_force.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/tests/lhdl_data.hpp"
#include "core/mesh_files/read_mesh.hpp"
#include "core/mesh_repair/repair_mesh.hpp"

namespace musclebench {
namespace {

/// Blocks of batches of all sizes and distances, some of them empty: all points are answered as one by one, to the bit.
void expect_answers_of_single_queries(const TriangleMesh& mesh, int blocks) {
  const TriangleBvh tree(mesh);
  Vec3 lower = mesh.vertices.front();
  Vec3 upper = lower;
  for (const Vec3& vertex : mesh.vertices) {
    lower = lower.cwiseMin(vertex);
    upper = upper.cwiseMax(vertex);
  }
  const double size = (upper - lower).norm();
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> unit(0, 1);
  std::uniform_int_distribution<std::size_t> vertices(0, mesh.vertices.size() - 1);
  std::uniform_int_distribution<int> triangles(0, static_cast<int>(mesh.triangles.size()) - 1);
  const auto noise = [&] { return Vec3(unit(generator) - 0.5, unit(generator) - 0.5, unit(generator) - 0.5); };
  int seed = 0;
  BatchedClosestPoint search(tree);
  for (int block = 0; block < blocks; ++block) {
    const double away = size * std::pow(10.0, -5 * unit(generator));
    const double width = block % 5 == 0 ? 0 : size * std::pow(10.0, -4 * unit(generator) - 0.5);
    const Vec3 middle = mesh.vertices[vertices(generator)] + (block % 3 == 0 ? Vec3(Vec3::Zero()) : away * noise());
    std::vector<PointBatch> batches(block % 2 == 0 ? 1 : 1 + static_cast<std::size_t>(block) % 19);
    for (std::size_t p = 0; p < batches.size(); ++p) {
      const Vec3 own_middle = middle + width * noise();
      for (std::size_t n = 0; n < (static_cast<std::size_t>(block) + 5 * p) % (PointBatch::capacity + 1); ++n) {
        batches[p].add(own_middle + 0.3 * width * noise());
      }
    }
    Eigen::AlignedBox3d box;
    for (const PointBatch& batch : batches) {
      for (std::size_t n = 0; n < batch.count; ++n) {
        box.extend(batch.point[n]);
      }
    }
    if (box.isEmpty()) {
      continue;
    }
    const Vec3 more = block % 7 == 0 ? Vec3(0.1 * width * Vec3::Ones()) : Vec3(Vec3::Zero());
    search.begin({box.min() - more, box.max() + more}, block % 4 == 0 ? triangles(generator) : seed);
    const std::span<PointBatch> all(batches);
    const std::size_t first_asked = static_cast<std::size_t>(block) % (all.size() + 1);
    search.closest_points(all.first(first_asked));
    search.closest_points(all.subspan(first_asked));
    for (const PointBatch& batch : batches) {
      for (std::size_t n = 0; n < batch.count; ++n) {
        SCOPED_TRACE(block);
        expect_equal(batch.closest[n], tree.closest_point(batch.point[n]).value());
        seed = batch.closest[n].triangle;
      }
    }
    if (testing::Test::HasFailure()) {
      return;
    }
  }
}

class BatchedClosestPointWithEachTarget : public testing::Test {
 protected:
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }

  static void expect_on_each_target(const TriangleMesh& mesh, int blocks) {
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      SCOPED_TRACE(hwy::TargetName(target));
      hwy::SetSupportedTargetsForTest(target);
      expect_answers_of_single_queries(mesh, blocks);
    }
  }
};

TEST_F(BatchedClosestPointWithEachTarget, IsThatOfSingleQueriesOnShapes) {
  expect_on_each_target(make_sphere(0.1, 4), 1000);
  expect_on_each_target(make_box({0.5, 0.2, 0.001}, 7), 1000);
  expect_on_each_target(make_capsule(0.01, 1, 32), 1000);
}

TEST_F(BatchedClosestPointWithEachTarget, IsThatOfSingleQueriesOnSliversAndFarFromTheOrigin) {
  std::mt19937 generator(5);
  std::normal_distribution<double> normal(0, 1);
  TriangleMesh soup;
  for (int t = 0; t < 3000; ++t) {
    const Vec3 at(50 + normal(generator), normal(generator), -30 + normal(generator));
    const Vec3 along(normal(generator), normal(generator), normal(generator));
    const double thin = t % 3 == 0 ? 1e-9 : 0.3;
    for (const double side : {0.0, 1.0, 0.5}) {
      soup.vertices.push_back(at + 0.2 * side * along +
                              0.2 * (side == 0.5 ? thin : 0.0) * Vec3(along.y(), -along.x(), 0.3));
    }
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  expect_on_each_target(soup, 1500);
}

TEST_F(BatchedClosestPointWithEachTarget, IsThatOfSingleQueriesOnThePelvis) {
  const auto folder = lhdl_folder();
  if (!folder) {
    GTEST_SKIP() << "the LHDL data are not here (set MUSCLEBENCH_DATA)";
  }
  expect_on_each_target(repair_mesh(read_mesh(*folder / "meshes/pelvis.ply"), "pelvis").mesh, 500);
}

}  // namespace
}  // namespace musclebench

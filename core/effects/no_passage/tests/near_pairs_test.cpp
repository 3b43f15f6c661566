#include "core/effects/no_passage/near_pairs.hpp"

#include <bit>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/effects/no_passage/passage_surfaces.hpp"
#include "core/effects/no_passage/triangle_axes.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

using Points = std::vector<Vec3>;

class Random {
 public:
  double number() { return 2 * static_cast<double>(m_random() >> 11) * 0x1p-53 - 1; }
  Vec3 vector() {
    const double x = number();
    const double y = number();
    return {x, y, number()};
  }

 private:
  std::mt19937_64 m_random{5};
};

std::array<Vec3, 3> corners(const TriangleMesh& mesh, std::size_t t, const Points& at) {
  const auto& [a, b, c] = mesh.triangles[t];
  return {at[static_cast<std::size_t>(a)], at[static_cast<std::size_t>(b)], at[static_cast<std::size_t>(c)]};
}

double distance(const std::array<Vec3, 3>& one, const std::array<Vec3, 3>& other) {
  double least = 1e9;
  for (std::size_t i = 0; i < 3; ++i) {
    least = std::min(least, distance_of(StencilKind::node_face, {one[i], other[0], other[1], other[2]}));
    least = std::min(least, distance_of(StencilKind::node_face, {other[i], one[0], one[1], one[2]}));
    for (std::size_t j = 0; j < 3; ++j) {
      least = std::min(least,
                       distance_of(StencilKind::edge_edge, {one[i], one[(i + 1) % 3], other[j], other[(j + 1) % 3]}));
    }
  }
  return least;
}

/// Whether triangles of these corners may be close.
bool are_near(const Vec3& one, const Vec3& other) { return (one - other).squaredNorm() < 1; }

Points between(const Points& start, const Points& end, double share) {
  Points at;
  for (std::size_t v = 0; v < start.size(); ++v) at.push_back(start[v] + share * (end[v] - start[v]));
  return at;
}

std::vector<VertexPath> paths_of(const Points& start, const Points& end, const Vec3& origin) {
  std::vector<VertexPath> paths;
  for (std::size_t v = 0; v < start.size(); ++v) paths.emplace_back(start[v], end[v], origin);
  return paths;
}

/// Two balls that shake and pass by each other, or one that shakes.
class NearPairsTest : public testing::TestWithParam<bool> {};

TEST_P(NearPairsTest, NoPairThatComesCloseIsOverlooked) {
  const bool is_itself = GetParam();
  const TriangleMesh ball = make_sphere(1, 2);
  const Vec3 origin(0.3, -0.2, 0.1);
  const TriangleTree tree(ball.triangles, ball.vertices, 0, ball.triangles.size());
  GivenPaths of_first(tree, ball.triangles, origin);
  GivenPaths of_second(tree, ball.triangles, origin);
  NearPairs pairs(of_first, is_itself ? of_first : of_second);
  const std::size_t triangles = ball.triangles.size();
  constexpr double least_m = 0.02;

  Random random;
  Points first = ball.vertices;
  Points second = ball.vertices;
  for (Vec3& vertex : second) vertex += Vec3(2.6, 0.3, 0);
  // Some of it always goes the same way, so that what bounds forget adds up.
  Points drift;
  for (std::size_t v = 0; v < 2 * first.size(); ++v) drift.push_back(0.015 * random.vector());
  std::size_t looked_at = 0;
  std::size_t came_close = 0;
  constexpr int steps = 20;
  for (int step = 0; step < steps; ++step) {
    Points first_end = first;
    Points second_end = second;
    const Vec3 rush = 0.05 * random.vector();
    for (std::size_t v = 0; v < first.size(); ++v) {
      first_end[v] += rush + drift[v] + 0.002 * random.vector();
      second_end[v] += rush + Vec3(-0.04, 0, 0) + drift[first.size() + v] + 0.002 * random.vector();
    }
    const std::vector<VertexPath> first_paths = paths_of(first, first_end, origin);
    const std::vector<VertexPath> second_paths = paths_of(second, second_end, origin);
    of_first.set(first_paths);
    of_second.set(second_paths);
    const Points& other = is_itself ? first : second;
    const Points& other_end = is_itself ? first_end : second_end;

    std::set<std::pair<std::size_t, std::size_t>> found;
    pairs.find(least_m);
    for (const int leaf : pairs.leaves()) {
      NearBlock& block = pairs.leaf(leaf);
      for (std::uint64_t bits = block.found; bits != 0; bits &= bits - 1) {
        const auto slot = static_cast<std::size_t>(std::countr_zero(bits));
        const std::size_t one = tree.triangle(block.first * bvh_width + slot / bvh_width);
        const std::size_t two = tree.triangle(block.second * bvh_width + slot % bvh_width);
        const bool swap = is_itself && two < one;
        EXPECT_TRUE(found.insert(swap ? std::pair(two, one) : std::pair(one, two)).second) << "twice";
        const double apart_m = distance(corners(ball, one, first), corners(ball, two, other));
        // What axes tell is no more than the truth.
        const auto path = [&](const std::vector<VertexPath>& paths, std::size_t t) {
          const auto& [a, b, c] = ball.triangles[t];
          return TrianglePath{&paths[static_cast<std::size_t>(a)], &paths[static_cast<std::size_t>(b)],
                              &paths[static_cast<std::size_t>(c)]};
        };
        const ApartAlongAxes axes =
            apart_along_axes(path(first_paths, one), path(is_itself ? first_paths : second_paths, two), least_m);
        EXPECT_LE(axes.start_m, apart_m + 1e-9);
        if (axes.stay_apart) {
          for (const double share : {0.0, 0.5, 1.0}) {
            EXPECT_GT(distance(corners(ball, one, between(first, first_end, share)),
                               corners(ball, two, between(other, other_end, share))),
                      least_m);
          }
        }
        float& left_m = block.left_m[slot / bvh_width][slot % bvh_width];
        left_m = std::max(left_m, static_cast<float>(apart_m) * (1 - lane_rounding));
      }
    }
    pairs.tell();
    looked_at += found.size();

    for (const double share : {0.0, 0.3, 0.7, 1.0}) {
      const Points at = between(first, first_end, share);
      const Points of_other = between(other, other_end, share);
      for (std::size_t one = 0; one < triangles; ++one) {
        for (std::size_t two = is_itself ? one + 1 : 0; two < triangles; ++two) {
          if (!are_near(corners(ball, one, at)[0], corners(ball, two, of_other)[0])) continue;
          if (!(distance(corners(ball, one, at), corners(ball, two, of_other)) < least_m)) continue;
          ++came_close;
          ASSERT_TRUE(found.contains({one, two})) << "step " << step << ", triangles " << one << " and " << two;
        }
      }
    }
    pairs.move_on();
    first = first_end;
    second = second_end;
  }
  EXPECT_GT(came_close, 100U);
  EXPECT_GT(looked_at, 100U);
  const std::size_t all = is_itself ? triangles * (triangles - 1) / 2 : triangles * triangles;
  EXPECT_LT(looked_at, all * steps / 10) << "it remembers nothing";
}

INSTANTIATE_TEST_SUITE_P(Surfaces, NearPairsTest, testing::Bool(),
                         [](const auto& surfaces) { return surfaces.param ? "Itself" : "TwoSurfaces"; });

}  // namespace
}  // namespace musclebench

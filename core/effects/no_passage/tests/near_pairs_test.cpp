#include "core/effects/no_passage/near_pairs.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <string>
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
bool are_near(const Vec3& one, const Vec3& other, double size_m) { return (one - other).norm() < size_m; }

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

/// Two balls that shake and pass by each other, or one that shakes. By how many surfaces there are, and how large they
/// are, m.
class NearPairsTest : public testing::TestWithParam<std::pair<bool, double>> {};

TEST_P(NearPairsTest, NoPairThatComesCloseIsOverlooked) {
  const auto [is_itself, size_m] = GetParam();
  const TriangleMesh ball = make_sphere(size_m, 2);
  const Vec3 origin = size_m * Vec3(0.3, -0.2, 0.1);
  const TriangleTree tree(ball.triangles, ball.vertices, 0, ball.triangles.size());
  GivenPaths of_first(tree, ball.triangles);
  GivenPaths of_second(tree, ball.triangles);
  NearPairs pairs(of_first, is_itself ? of_first : of_second);
  const std::size_t triangles = ball.triangles.size();
  const double least_m = 0.02 * size_m;

  Random random;
  Points first = ball.vertices;
  Points second = ball.vertices;
  for (Vec3& vertex : second) vertex += size_m * Vec3(2.6, 0.3, 0);
  // Some of it always goes the same way, so that what bounds forget adds up.
  Points drift;
  for (std::size_t v = 0; v < 2 * first.size(); ++v) drift.push_back(0.015 * size_m * random.vector());
  std::size_t looked_at = 0;
  std::size_t came_close = 0;
  constexpr int steps = 20;
  for (int step = 0; step < steps; ++step) {
    Points first_end = first;
    Points second_end = second;
    const Vec3 rush = 0.05 * size_m * random.vector();
    for (std::size_t v = 0; v < first.size(); ++v) {
      first_end[v] += rush + drift[v] + 0.002 * size_m * random.vector();
      second_end[v] += rush + size_m * Vec3(-0.04, 0, 0) + drift[first.size() + v] + 0.002 * size_m * random.vector();
    }
    if (step == 13) {
      // A flight there and back, so that much was open between what touches.
      Points scattered = first;
      for (Vec3& vertex : scattered) vertex += 10 * size_m * random.vector();
      const std::array<const Points*, 5> places{&first, &scattered, &first, &first, &first};
      for (std::size_t k = 0; k + 1 < places.size(); ++k) {
        const std::vector<VertexPath> flying = paths_of(*places[k], *places[k + 1], origin);
        const std::vector<VertexPath> still = paths_of(second, second, origin);
        of_first.set(flying, origin);
        of_second.set(still, origin);
        pairs.find(least_m);
        pairs.tell();
        pairs.move_on();
      }
    }
    if (step % 3 == 1) {
      // As who looks whether anything intersects now.
      const std::vector<VertexPath> resting = paths_of(first, first, origin);
      const std::vector<VertexPath> other_resting = paths_of(second, second, origin);
      of_first.set(resting, origin);
      of_second.set(other_resting, origin);
      pairs.find(0);
      pairs.tell();
    }
    std::vector<VertexPath> first_paths = paths_of(first, first_end, origin);
    const std::vector<VertexPath> second_paths = paths_of(second, second_end, origin);
    of_first.set(first_paths, origin);
    of_second.set(second_paths, origin);
    const Points& other = is_itself ? first : second;
    const Points& other_end = is_itself ? first_end : second_end;

    for (int round = 0; round < 2; ++round) {
      std::vector<char> has_changed(first.size(), 1);
      if (round > 0) {
        std::vector<int> changed;
        for (std::size_t v = 0; v < first.size(); ++v) {
          has_changed[v] = static_cast<char>(v % 11 == 0);
          if (has_changed[v] == 0) continue;
          first_end[v] += 0.2 * size_m * random.vector();
          first_paths[v] = VertexPath(first[v], first_end[v], origin);
          changed.push_back(static_cast<int>(v));
        }
        of_first.change(changed);
        if (!is_itself) of_second.change({});
      }
      const auto is_of_changed = [&](std::size_t t) {
        return std::ranges::any_of(ball.triangles[t],
                                   [&](int v) { return has_changed[static_cast<std::size_t>(v)] != 0; });
      };
      std::set<std::pair<std::size_t, std::size_t>> found;
      pairs.find(least_m);
      for (NearPair& pair : pairs.found()) {
        const std::size_t one = tree.triangle(pair.first);
        const std::size_t two = tree.triangle(pair.second);
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
        EXPECT_LE(axes.start_m, (1 + 1e-9) * apart_m);
        if (axes.stay_apart) {
          for (const double share : {0.0, 0.5, 1.0}) {
            EXPECT_GT(distance(corners(ball, one, between(first, first_end, share)),
                               corners(ball, two, between(other, other_end, share))),
                      least_m);
          }
        }
        EXPECT_LE(pair.left_m, (1 + 1e-5) * apart_m) << "more than the truth";
        pair.left_m = std::max(pair.left_m, static_cast<float>(apart_m) * (1 - lane_rounding));
      }
      pairs.tell();
      looked_at += round == 0 ? found.size() : 0;

      for (const double share : {0.0, 0.3, 0.7, 1.0}) {
        const Points at = between(first, first_end, share);
        const Points of_other = between(other, other_end, share);
        for (std::size_t one = 0; one < triangles; ++one) {
          for (std::size_t two = is_itself ? one + 1 : 0; two < triangles; ++two) {
            if (!is_of_changed(one) && (!is_itself || !is_of_changed(two))) continue;
            if (!are_near(corners(ball, one, at)[0], corners(ball, two, of_other)[0], size_m)) continue;
            if (!(distance(corners(ball, one, at), corners(ball, two, of_other)) < least_m)) continue;
            ++came_close;
            ASSERT_TRUE(found.contains({one, two}))
                << "step " << step << ", round " << round << ", triangles " << one << " and " << two;
          }
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

INSTANTIATE_TEST_SUITE_P(Surfaces, NearPairsTest,
                         testing::Values(std::pair(true, 1.0), std::pair(false, 1.0), std::pair(false, 1e-6)),
                         [](const auto& of) {
                           return std::string(of.param.first ? "Itself" : "Two") + (of.param.second < 1 ? "Small" : "");
                         });

/// Two balls of 1 m, which are one mesh, and their pairs.
struct TwoBalls {
  explicit TwoBalls(int subdivisions) : ball(make_sphere(1, subdivisions)) {}

  TriangleMesh ball;
  TriangleTree tree{ball.triangles, ball.vertices, 0, ball.triangles.size()};
  GivenPaths first{tree, ball.triangles};
  GivenPaths second{tree, ball.triangles};
  NearPairs pairs{first, second};
};

TEST(NearPairs, AFlightLeavesNothingOpen) {
  TwoBalls balls(3);
  const TriangleMesh& ball = balls.ball;
  Points far = ball.vertices;
  for (Vec3& vertex : far) vertex += Vec3(100, 0, 0);
  const auto step = [&](const Points& from, const Points& to) {
    const std::vector<VertexPath> still = paths_of(ball.vertices, ball.vertices, Vec3::Zero());
    const std::vector<VertexPath> flying = paths_of(from, to, Vec3::Zero());
    balls.first.set(still, Vec3::Zero());
    balls.second.set(flying, Vec3::Zero());
    balls.pairs.find(1e-3);
    balls.pairs.tell();
    balls.pairs.move_on();
    return balls.pairs.bytes();
  };
  Points scattered = far;
  Random random;
  for (Vec3& vertex : scattered) vertex += Vec3(-100, 0, 0) + 100 * random.vector();
  const std::size_t before = step(far, far);
  const std::size_t open = step(far, scattered);
  std::size_t after = 0;
  for (int level = 0; level <= balls.tree.top(); ++level) after = step(far, far);  // one more closes in each step
  EXPECT_GT(open, 100 * before);
  EXPECT_LT(after, 20 * before);
}

TEST(NearPairs, WhatStaysAsItIsIsNotLookedAtAgain) {
  TwoBalls balls(2);
  Points moved = balls.ball.vertices;
  for (Vec3& vertex : moved) vertex.x() += 1.98;
  const std::vector<VertexPath> moving = paths_of(moved, moved, Vec3::Zero());
  const std::vector<VertexPath> still = paths_of(balls.ball.vertices, balls.ball.vertices, Vec3::Zero());
  balls.first.set(moving, Vec3::Zero());
  balls.second.set(still, Vec3::Zero());
  balls.pairs.find(0.05);
  EXPECT_FALSE(balls.pairs.found().empty());
  balls.pairs.tell();
  // A bone's own paths are set once, and none of them is ever told to have changed.
  balls.first.change({});
  balls.pairs.find(0.05);
  EXPECT_TRUE(balls.pairs.found().empty());
}

/// Slivers and specks have axes whose squared lengths single precision can't tell from 0.
TEST(TriangleAxes, TellNoMoreThanTheDistance) {
  Random random;
  for (const double size_m : {1.0, 1e-3, 1e-6, 1e-8}) {
    for (const double thin : {1.0, 1e-3, 1e-6}) {
      for (int i = 0; i < 2000; ++i) {
        std::array<std::array<Vec3, 3>, 2> triangles;
        for (auto& triangle : triangles) {
          const Vec3 along = size_m * random.vector();
          triangle[0] = size_m * random.vector();
          triangle[1] = triangle[0] + along;
          triangle[2] = triangle[0] + random.number() * along + thin * size_m * random.vector();
        }
        std::array<std::array<VertexPath, 3>, 2> paths;
        for (std::size_t side = 0; side < 2; ++side) {
          for (std::size_t k = 0; k < 3; ++k) {
            paths[side][k] = VertexPath(triangles[side][k], triangles[side][k], Vec3::Zero());
          }
        }
        const auto path = [&](std::size_t side) {
          return TrianglePath{&paths[side][0], &paths[side][1], &paths[side][2]};
        };
        const double apart_m = distance(triangles[0], triangles[1]);
        const double least_m = 0.1 * size_m;
        const ApartAlongAxes axes = apart_along_axes(path(0), path(1), least_m);
        ASSERT_LE(axes.start_m, apart_m) << size_m << ", " << thin;
        ASSERT_TRUE(!axes.stay_apart || apart_m > least_m) << size_m << ", " << thin;
      }
    }
  }
}

}  // namespace
}  // namespace musclebench

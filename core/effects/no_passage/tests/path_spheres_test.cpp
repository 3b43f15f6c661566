#include "core/effects/no_passage/path_spheres.hpp"

#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random_numbers.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

class PathSpheresTest : public testing::Test {
 protected:
  PathSpheresTest() : m_tree(m_ball.triangles, m_ball.vertices, 0, m_ball.triangles.size(), 4) {
    for (const Vec3& vertex : m_start) m_end.push_back(vertex + 0.05 * vector());
    for (std::size_t v = 0; v < m_start.size(); ++v) m_paths.emplace_back(m_start[v], m_end[v], m_origin);
  }

  Vec3 vector() {
    const double x = 2 * m_random.share() - 1;
    const double y = 2 * m_random.share() - 1;
    return {x, y, 2 * m_random.share() - 1};
  }

  /// The vertices below a node of any level above triangles.
  [[nodiscard]] std::set<int> vertices_below(int level, std::size_t node) const {
    if (level == 1) {
      const auto of = m_tree.vertices(1, node);
      return {of.begin(), of.end()};
    }
    std::set<int> all;
    for (std::size_t child = node * bvh_width; child < std::min((node + 1) * bvh_width, m_tree.size(level - 1));
         ++child) {
      all.merge(vertices_below(level - 1, child));
    }
    return all;
  }

  /// That each sphere holds its vertices where their paths start, and that none moves otherwise than it says.
  void expect_bounds(PathSpheres& spheres, const std::vector<Vec3>& start, const std::vector<Vec3>& end,
                     const Vec3& origin) const {
    for (int level = 0; level < m_tree.top(); ++level) {
      for (std::size_t node = 0; node < m_tree.size(level); ++node) {
        const SphereLanes& lanes = spheres.below(level + 1, node / bvh_width);
        const std::size_t lane = node % bvh_width;
        const auto at = [&](const std::array<BvhLanes, 3>& of) { return Vec3(of[0][lane], of[1][lane], of[2][lane]); };
        std::set<int> below;
        if (level > 0) {
          below = vertices_below(level, node);
        } else {
          for (const int vertex : m_ball.triangles[m_tree.triangle(node)]) below.insert(vertex);
        }
        double farthest_m = 0;
        for (const int vertex : below) {
          const auto v = static_cast<std::size_t>(vertex);
          farthest_m = std::max(farthest_m, (start[v] - origin - at(lanes.from)).norm());
          EXPECT_LE((end[v] - start[v] - at(lanes.move)).norm(), lanes.spread_m[lane]) << level;
        }
        EXPECT_LE(farthest_m, lanes.radius_m[lane]);
        EXPECT_GT(farthest_m, 0.4 * lanes.radius_m[lane]) << "a sphere of level " << level << " is much too large";
      }
    }
  }

  RandomNumbers m_random{3};
  TriangleMesh m_ball = make_sphere(1, 2);
  TriangleTree m_tree;
  std::vector<Vec3> m_start = m_ball.vertices;
  std::vector<Vec3> m_end;
  Vec3 m_origin{0.2, -3, 0.5};
  std::vector<VertexPath> m_paths;
};

TEST_F(PathSpheresTest, HoldTheirVerticesAndHowTheyMove) {
  GivenPaths spheres(m_tree, m_ball.triangles);
  spheres.set(m_paths, m_origin);
  expect_bounds(spheres, m_start, m_end, m_origin);
}

TEST_F(PathSpheresTest, HoldThemInABoneThatTurns) {
  GivenPaths given(m_tree, m_ball.triangles);
  given.set(m_paths, m_origin);
  const RigidMotion from = RigidMotion::about_axis(Vec3(1, 2, 2) / 3, Vec3(0, 1, 0), 0.4);
  const RigidMotion to = RigidMotion::about_axis(Vec3(2, -1, 2) / 3, Vec3(0.1, 0.9, 0), 0.9) * from;
  const Vec3 origin(-0.5, 1, 0);
  const std::vector<char> is_carried(m_start.size(), 0);
  PathsInBone in_bone(given, m_ball.triangles, is_carried, 0, m_start.size(), origin);
  in_bone.set(m_start, m_end, from, to);
  std::vector<Vec3> start;
  std::vector<Vec3> end;
  for (const Vec3& vertex : m_start) start.push_back(from.apply_inverse(vertex));
  for (const Vec3& vertex : m_end) end.push_back(to.apply_inverse(vertex));
  expect_bounds(in_bone, start, end, origin);
}

TEST_F(PathSpheresTest, AreMadeAnewWhereVerticesMovedAgain) {
  GivenPaths spheres(m_tree, m_ball.triangles);
  spheres.set(m_paths, m_origin);
  expect_bounds(spheres, m_start, m_end, m_origin);
  EXPECT_TRUE(spheres.is_all_changed());
  const std::vector<int> moved{3, 50, 51};
  for (const int vertex : moved) {
    const auto v = static_cast<std::size_t>(vertex);
    m_end[v] += Vec3(0.3, 0.1, 0);
    m_paths[v] = VertexPath(m_start[v], m_end[v], m_origin);
  }
  spheres.change(moved);
  expect_bounds(spheres, m_start, m_end, m_origin);
  std::size_t changed = 0;
  for (std::size_t leaf = 0; leaf < m_tree.size(1); ++leaf) {
    const auto of = m_tree.vertices(1, leaf);
    const bool has_moved = std::ranges::any_of(of, [&](int v) { return std::ranges::count(moved, v) > 0; });
    EXPECT_EQ(spheres.changed(1)[static_cast<int>(leaf)], has_moved);
    changed += has_moved ? 1 : 0;
  }
  EXPECT_LT(changed, m_tree.size(1));
}

TEST_F(PathSpheresTest, WhatTheBoneCarriesIsNowhere) {
  GivenPaths given(m_tree, m_ball.triangles);
  given.set(m_paths, m_origin);
  std::vector<char> is_carried(m_start.size(), 0);
  for (const int vertex : m_tree.vertices(1, 2)) is_carried[static_cast<std::size_t>(vertex)] = 1;
  PathsInBone in_bone(given, m_ball.triangles, is_carried, 0, m_start.size(), Vec3::Zero());
  in_bone.set(m_start, m_end, {}, {});
  EXPECT_LT(in_bone.below(2, 0).radius_m[2], -1);
  EXPECT_GT(in_bone.below(2, 0).radius_m[0], 0);
}

}  // namespace
}  // namespace musclebench

#include "core/clearance/moving_clearances.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

constexpr double radius_m = 0.02;

/// Two balls, 4 mm apart, and the exact distance of a node to the ball that is not its own.
class TwoBallsBeside : public testing::Test {
 protected:
  TwoBallsBeside() {
    const TriangleMesh ball = make_sphere(radius_m, 4);
    for (const double x : {0.0, 0.044}) {
      const auto first_node = static_cast<int>(m_mesh.vertices.size());
      const std::size_t first_triangle = m_mesh.triangles.size();
      for (const Vec3& vertex : ball.vertices) m_mesh.vertices.push_back(vertex + Vec3(x, 0, 0));
      for (const auto& [a, b, c] : ball.triangles) {
        m_mesh.triangles.push_back({first_node + a, first_node + b, first_node + c});
      }
      m_bodies.push_back(
          {"ball", first_node, static_cast<int>(m_mesh.vertices.size()), first_triangle, m_mesh.triangles.size()});
      m_centres.emplace_back(x, 0, 0);
    }
  }

  /// Moves each point to `motion(body, point)` and returns the nodes that have expired.
  std::vector<int> step(MovingClearances& clearances, const std::function<Vec3(int, const Vec3&)>& motion) {
    std::vector<Vec3> moved;
    for (int node = 0; node < static_cast<int>(m_mesh.vertices.size()); ++node) {
      moved.push_back(motion(body(node), m_positions[static_cast<std::size_t>(node)]));
    }
    m_positions = moved;
    for (int i = 0; i < 2; ++i) {
      m_centres[static_cast<std::size_t>(i)] = motion(i, m_centres[static_cast<std::size_t>(i)]);
    }
    clearances.update(m_positions, 1);
    return {clearances.expired().begin(), clearances.expired().end()};
  }

  [[nodiscard]] int body(int node) const { return m_bodies[0].has_node(node) ? 0 : 1; }
  [[nodiscard]] double distance_m(int node) const {
    return (m_positions[static_cast<std::size_t>(node)] - m_centres[static_cast<std::size_t>(1 - body(node))]).norm() -
           radius_m;
  }
  void store_all(MovingClearances& clearances) const {
    for (int node = 0; node < static_cast<int>(m_positions.size()); ++node) clearances.store(node, distance_m(node));
  }

  TriangleMesh m_mesh;
  std::vector<Body> m_bodies;
  std::vector<Vec3> m_centres;
  std::vector<Vec3> m_positions;

  void SetUp() override { m_positions = m_mesh.vertices; }
  [[nodiscard]] TouchingMuscles touching() const { return {m_mesh, m_bodies, {{0, 1}}}; }
};

TEST_F(TwoBallsBeside, AllExpireBeforeAnythingIsKnown) {
  MovingClearances clearances(touching());
  const std::vector<int> expired = step(clearances, [](int, const Vec3& p) { return p; });
  EXPECT_EQ(expired.size(), m_positions.size());
  for (const int node : expired) EXPECT_EQ(clearances.excess_travel_m(node), std::numeric_limits<double>::infinity());
}

/// A tenth of a degree a step about an axis 0.3 m away: every node travels 0.5 mm, past its clearance in ten steps.
TEST_F(TwoBallsBeside, ThoseThatTravelTogetherKeepTheirClearance) {
  MovingClearances clearances(touching());
  step(clearances, [](int, const Vec3& p) { return p; });
  store_all(clearances);
  const Eigen::AngleAxisd turn(0.1 * M_PI / 180, Vec3::UnitZ());
  const Vec3 axis(0, -0.3, 0);
  std::size_t expired = 0;
  for (int i = 0; i < 40; ++i) {
    expired = step(clearances, [&](int, const Vec3& p) { return Vec3(axis + turn * (p - axis)); }).size();
  }
  EXPECT_GT((m_positions[0] - m_mesh.vertices[0]).norm(), 0.015);
  EXPECT_LT(expired, m_positions.size() / 5);
}

/// A node expires before the balls have come closer than its distance, and says how far it may have gone beyond.
TEST_F(TwoBallsBeside, NoneOutlivesItsDistance) {
  MovingClearances clearances(touching());
  step(clearances, [](int, const Vec3& p) { return p; });
  store_all(clearances);
  std::vector<double> stored;
  for (int node = 0; node < static_cast<int>(m_positions.size()); ++node) stored.push_back(distance_m(node));
  for (int i = 1; i <= 60; ++i) {
    const std::vector<int> expired =
        step(clearances, [](int body, const Vec3& p) { return Vec3(p + (body == 0 ? 1e-4 : -1e-4) * Vec3::UnitX()); });
    const double closer_m = 2e-4 * i;
    for (int node = 0; node < static_cast<int>(m_positions.size()); ++node) {
      const double left_m = stored[static_cast<std::size_t>(node)] - closer_m;
      const bool is_expired = std::find(expired.begin(), expired.end(), node) != expired.end();
      if (left_m < 0) {
        ASSERT_TRUE(is_expired) << "node " << node << " in step " << i;
      }
      if (is_expired) {
        ASSERT_GE(clearances.excess_travel_m(node), -left_m - 1e-12);
      }
    }
  }
}

/// Both ends of the second muscle are far from a ball that lies beside the triangles between them.
TEST(MovingClearances, ATriangleBetweenClustersIsNear) {
  const TriangleMesh ball = make_sphere(0.005, 3);
  TriangleMesh mesh;
  std::vector<Body> bodies;
  const auto add_ball = [&](const Vec3& centre) {
    const auto first = static_cast<int>(mesh.vertices.size());
    for (const Vec3& vertex : ball.vertices) mesh.vertices.push_back(vertex + centre);
    for (const auto& [a, b, c] : ball.triangles) mesh.triangles.push_back({first + a, first + b, first + c});
    return first;
  };
  add_ball(Vec3(0, 0, 0.008));
  const auto own = static_cast<int>(mesh.vertices.size());
  bodies.push_back({"ball", 0, own, 0, mesh.triangles.size()});
  const int left = add_ball(Vec3(-0.5, 0, 0));
  const int right = add_ball(Vec3(0.5, 0, 0));
  mesh.triangles.push_back({left, right, right + 1});
  bodies.push_back(
      {"two ends", own, static_cast<int>(mesh.vertices.size()), bodies[0].last_triangle, mesh.triangles.size()});
  MovingClearances clearances(TouchingMuscles{mesh, bodies, {{0, 1}}});
  std::vector<Vec3> positions = mesh.vertices;
  clearances.update(positions, 1);
  for (int node = 0; node < static_cast<int>(positions.size()); ++node) clearances.store(node, 0.003);
  std::size_t expired = 0;
  for (int i = 0; i < 40; ++i) {
    for (std::size_t node = static_cast<std::size_t>(own); node < positions.size(); ++node) positions[node].z() += 1e-4;
    clearances.update(positions, 1);
    expired = static_cast<std::size_t>(std::ranges::count_if(clearances.expired(), [&](int n) { return n < own; }));
  }
  EXPECT_EQ(expired, static_cast<std::size_t>(own));  // it came 4 mm closer, to all of them
}

TEST_F(TwoBallsBeside, ALeapLeavesNothingKnown) {
  MovingClearances clearances(touching());
  step(clearances, [](int, const Vec3& p) { return p; });
  store_all(clearances);
  const std::vector<int> expired =
      step(clearances, [](int body, const Vec3& p) { return Vec3(p + (body == 0 ? 0.2 : 0.0) * Vec3::UnitY()); });
  EXPECT_EQ(expired.size(), m_positions.size());
}

}  // namespace
}  // namespace musclebench

// What the loop over nodes and muscles asks of a structure, and what it makes of the answers.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/clearance/deforming_structure.hpp"

namespace musclebench {
namespace {

/// A ball about the middle of a muscle's nodes, which answers by the letter of DeformingStructure: no farther than
/// `enough_m`.
class Ball final : public DeformingStructure {
 public:
  Ball(Body body, double radius) : m_body(std::move(body)), m_radius_m(radius) {}

  void update(std::span<const Vec3> positions, int) override {
    m_centre = Vec3::Zero();
    for (int node = m_body.first_node; node < m_body.last_node; ++node) {
      m_centre += positions[static_cast<std::size_t>(node)] / (m_body.last_node - m_body.first_node);
    }
  }

  [[nodiscard]] MuscleAnswer query(const Vec3& point, const MuscleQuery& wanted, int& guess) const override {
    const double outside_m = (point - m_centre).norm() - m_radius_m;
    const double distance_m = std::abs(outside_m);
    if (distance_m > wanted.enough_m) return {wanted.enough_m};
    guess = static_cast<int>(m_body.first_triangle);
    if (outside_m > 0 || distance_m <= wanted.touching_m || distance_m > wanted.excess_travel_m) return {distance_m};
    const Vec3 closest = m_centre + m_radius_m * (point - m_centre).normalized();
    return {0, guess, {closest, distance_m * distance_m, Feature::face}};
  }

  [[nodiscard]] std::size_t bytes() const override { return sizeof(*this); }

 private:
  Body m_body;
  double m_radius_m;
  Vec3 m_centre = Vec3::Zero();
};

/// A small muscle of three nodes near the origin between two balls.
class NodesBetweenBalls : public testing::Test {
 protected:
  static constexpr double ball_m = 0.02;

  /// The contacts with balls about these centres.
  std::vector<MuscleContact> detect(const Vec3& first, const Vec3& second, bool has_cache) {
    TriangleMesh mesh;
    std::vector<Body> bodies;
    for (const Vec3& centre : {Vec3(0, 0, 0), first, second}) {
      const auto node = static_cast<int>(mesh.vertices.size());
      const std::size_t triangle = mesh.triangles.size();
      for (const Vec3& corner : {Vec3(0, 0, 0), Vec3(1e-4, 0, 0), Vec3(0, 1e-4, 0)}) {
        mesh.vertices.push_back(centre + corner);
      }
      mesh.triangles.push_back({node, node + 1, node + 2});
      bodies.push_back({"muscle", node, node + 3, triangle, triangle + 1});
    }
    const auto build = [](const TriangleMesh&, const Body& body) {
      return std::make_unique<Ball>(body, body.first_node == 0 ? 1e-9 : ball_m);
    };
    const TouchingMuscles muscles{mesh, bodies, {{0, 1}, {0, 2}}};
    const auto detector = make_point_muscle_detector({has_cache, build}, muscles, 1);
    std::vector<MuscleContact> contacts;
    detector->detect(mesh.vertices, contacts);
    return contacts;
  }

  static bool has(const std::vector<MuscleContact>& contacts, int node, int muscle) {
    return std::ranges::any_of(contacts,
                               [&](const auto& found) { return found.node == node && found.muscle == muscle; });
  }
};

/// A node that is free of one muscle by a hair is in another all the same: the first clearance ends no search there.
TEST_F(NodesBetweenBalls, ASmallClearanceHidesNoContactWithAnotherMuscle) {
  for (const bool has_cache : {false, true}) {
    const std::vector<MuscleContact> contacts =
        detect(Vec3(ball_m + 0.001, 0, 0), Vec3(0, ball_m - 0.01, 0), has_cache);
    ASSERT_EQ(contacts.size(), 3U);
    for (int node = 0; node < 3; ++node) {
      EXPECT_EQ(contacts[static_cast<std::size_t>(node)].node, node);
      EXPECT_EQ(contacts[static_cast<std::size_t>(node)].muscle, 2);
      EXPECT_NEAR(contacts[static_cast<std::size_t>(node)].depth_m, 0.01, 2e-4);
    }
  }
}

TEST_F(NodesBetweenBalls, ANodeInTwoMusclesHasAContactWithEach) {
  for (const bool has_cache : {false, true}) {
    const std::vector<MuscleContact> contacts =
        detect(Vec3(ball_m - 0.002, 0, 0), Vec3(0, ball_m - 0.01, 0), has_cache);
    for (int node = 0; node < 3; ++node) {
      EXPECT_TRUE(has(contacts, node, 1)) << node;
      EXPECT_TRUE(has(contacts, node, 2)) << node;
    }
  }
}

TEST_F(NodesBetweenBalls, AreFreeWhereBothAreAway) {
  for (const bool has_cache : {false, true}) {
    EXPECT_TRUE(detect(Vec3(0.03, 0, 0), Vec3(0, 0.04, 0), has_cache).empty());
  }
}

}  // namespace
}  // namespace musclebench

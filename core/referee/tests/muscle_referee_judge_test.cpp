// The Referee between muscles, against boxes whose depth is known.
#include <algorithm>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/mesh/shapes.hpp"
#include "core/referee/muscle_referee.hpp"

namespace musclebench {
namespace {

struct Box {
  Vec3 half_m;
  Vec3 centre_m;

  /// How deep a point is inside; negative outside.
  [[nodiscard]] double depth_m(const Vec3& point) const { return (half_m - (point - centre_m).cwiseAbs()).minCoeff(); }
};

/// Two boxes side by side, each stretched and moved.
class TwoBoxes : public testing::Test {
 protected:
  TwoBoxes() {
    for (const Box& box : rest) {
      const TriangleMesh shape = make_box(box.half_m, 6);
      const auto first = static_cast<int>(m_mesh.vertices.size());
      const std::size_t first_triangle = m_mesh.triangles.size();
      for (const Vec3& vertex : shape.vertices) m_mesh.vertices.push_back(box.centre_m + vertex);
      for (const auto& [a, b, c] : shape.triangles) m_mesh.triangles.push_back({first + a, first + b, first + c});
      m_bodies.push_back(
          {"box", first, static_cast<int>(m_mesh.vertices.size()), first_triangle, m_mesh.triangles.size()});
    }
  }

  [[nodiscard]] std::vector<Vec3> positions(const std::vector<Box>& now) const {
    std::vector<Vec3> moved = m_mesh.vertices;
    for (std::size_t node = 0; node < moved.size(); ++node) {
      const std::size_t body = body_of(m_bodies, static_cast<int>(node));
      moved[node] = now[body].centre_m +
                    (moved[node] - rest[body].centre_m).cwiseQuotient(rest[body].half_m).cwiseProduct(now[body].half_m);
    }
    return moved;
  }

  /// Judges and compares with the depth in the other box.
  void expect_right(MuscleReferee& referee, const std::vector<Box>& now, std::size_t least_contacts) const {
    const std::vector<Vec3> at = positions(now);
    std::vector<Contact> found;
    referee.judge(at, found);
    struct Depth {
      int node;
      int other;
      double depth_m;
    };
    std::vector<Depth> expected;
    for (std::size_t node = 0; node < at.size(); ++node) {
      const int other = 1 - static_cast<int>(body_of(m_bodies, static_cast<int>(node)));
      const double depth_m = now[static_cast<std::size_t>(other)].depth_m(at[node]);
      if (depth_m > 1e-9) expected.push_back({static_cast<int>(node), other, depth_m});
    }
    ASSERT_GE(expected.size(), least_contacts);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].node, expected[i].node);
      EXPECT_EQ(found[i].bone, expected[i].other);
      EXPECT_NEAR(found[i].depth_m, expected[i].depth_m, 1e-12);
    }
  }

  const std::vector<Box> rest = {{Vec3(0.01, 0.012, 0.014), Vec3(0, 0, 0)}, {Vec3(0.01, 0.01, 0.01), Vec3(0.03, 0, 0)}};
  TriangleMesh m_mesh;
  std::vector<Body> m_bodies;
};

TEST_F(TwoBoxes, AreJudgedWhereTheyAreNow) {
  MuscleReferee referee(m_mesh, {m_bodies, {{1}, {0}}});
  expect_right(referee, rest, 0);
  expect_right(referee, {rest[0], {rest[1].half_m, Vec3(0.015, 0.001, 0.002)}}, 20);
  expect_right(referee, {{Vec3(0.022, 0.02, 0.02), Vec3(0, 0, 0.001)}, rest[1]}, 20);
  expect_right(referee, {rest[0], {Vec3(0.005, 0.003, 0.004), Vec3(0.001, 0.0005, 0)}}, 200);
  expect_right(referee, rest, 0);
}

TEST_F(TwoBoxes, AreJudgedOnlyAgainstThoseBesideThem) {
  MuscleReferee referee(m_mesh, {m_bodies, {{1}, {}}});
  std::vector<Contact> found;
  referee.judge(positions({rest[0], {rest[1].half_m, Vec3(0.015, 0.001, 0.002)}}), found);
  EXPECT_FALSE(found.empty());
  EXPECT_TRUE(std::ranges::all_of(found, [](const Contact& contact) { return contact.bone == 1; }));
}

TEST_F(TwoBoxes, AMuscleWithoutTrianglesIsNamed) {
  m_bodies[1].last_triangle = m_bodies[1].first_triangle;
  EXPECT_THROW(MuscleReferee(m_mesh, {m_bodies, {{1}, {0}}}), InputError);
}

}  // namespace
}  // namespace musclebench

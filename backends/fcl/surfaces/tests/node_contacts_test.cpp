#include "backends/fcl/surfaces/node_contacts.hpp"

#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

/// One muscle triangle and a box of 2 x 4 x 6 cm; pairs are given by hand.
class NodeContactsTest : public testing::Test {
 protected:
  std::vector<Contact> contacts(const std::vector<Vec3>& positions, std::vector<TrianglePair> pairs,
                                const std::vector<int>& wanted = {0, 1, 2}) {
    NodeContacts nodes(pointers_to(m_bones), {{0, 1, 2}}, 3);
    std::vector<Contact> found;
    nodes.append(0, RigidMotion{}, pairs, positions, wanted, found);
    std::reverse(pairs.begin(), pairs.end());
    std::vector<Contact> again;
    nodes.append(0, RigidMotion{}, pairs, positions, wanted, again);
    EXPECT_EQ(found.size(), again.size());
    for (std::size_t i = 0; i < std::min(found.size(), again.size()); ++i) {
      EXPECT_EQ(found[i].node, again[i].node);
      EXPECT_EQ(found[i].depth_m, again[i].depth_m);
      EXPECT_EQ(found[i].normal, again[i].normal) << "the order of the pairs matters";
    }
    return found;
  }

  /// The triangles of the face whose outward normal is `normal`.
  std::vector<TrianglePair> face(const Vec3& normal) const {
    const TriangleMesh& mesh = m_bones[0].surface.mesh;
    std::vector<TrianglePair> pairs;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto corner = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][i])]; };
      if ((corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized().dot(normal) > 0.99) {
        pairs.push_back({0, static_cast<int>(t)});
      }
    }
    return pairs;
  }

  std::vector<Bone> m_bones = {Bone{"box", {make_box({0.01, 0.02, 0.03}, 1), true, {}}}};
};

TEST_F(NodeContactsTest, MeasuresAgainstTheClosestOfThePairedTriangles) {
  std::vector<TrianglePair> pairs = face(Vec3::UnitX());
  const auto top = face(Vec3::UnitZ());
  pairs.insert(pairs.end(), top.begin(), top.end());
  ASSERT_EQ(pairs.size(), 4U);
  // Inside near the top, inside near the side, outside.
  const auto found = contacts({{0.001, 0.004, 0.028}, {0.009, 0.003, 0.001}, {0.011, 0, 0.01}}, pairs);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].node, 0);
  EXPECT_NEAR(found[0].depth_m, 0.002, 1e-15);
  EXPECT_LT((found[0].normal - Vec3::UnitZ()).norm(), 1e-15);
  EXPECT_EQ(found[1].node, 1);
  EXPECT_NEAR(found[1].depth_m, 0.001, 1e-15);
  EXPECT_LT((found[1].normal - Vec3::UnitX()).norm(), 1e-15);
}

TEST_F(NodeContactsTest, AtEqualDistanceTheOrderOfPairsDoesNotMatter) {
  std::vector<TrianglePair> pairs = face(Vec3::UnitX());
  const auto opposite = face(-Vec3::UnitX());
  pairs.insert(pairs.end(), opposite.begin(), opposite.end());
  const auto found = contacts({{0, 0.001, 0.002}, {0, -0.004, 0.002}, {0, 0.003, -0.001}}, pairs);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].depth_m, 0.01);
}

TEST_F(NodeContactsTest, TellsTheSideOfAnEdgeByBothItsFaces) {
  // Only the side is paired; above it, diagonally, the closest point is the upper edge.
  const auto side = face(Vec3::UnitX());
  EXPECT_TRUE(contacts({{0.0101, 0, 0.032}, {0.0105, 0, 0.0301}, {0.011, 0, 0.031}}, side).empty());
  // Straight above the top face and behind the side's plane: outside, which the side alone would call inside.
  EXPECT_TRUE(contacts({{0.0099, 0, 0.032}, {0.0098, 0, 0.032}, {0.0097, 0, 0.032}}, side).empty());
}

TEST_F(NodeContactsTest, AnswersOnlyForWantedNodesOfPairedTriangles) {
  const std::vector<Vec3> positions = {{0.009, 0, 0}, {0.009, 0.001, 0}, {0.009, 0, 0.001}};
  const auto found = contacts(positions, face(Vec3::UnitX()), {1});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].node, 1);
  EXPECT_TRUE(contacts(positions, {}).empty());
}

TEST_F(NodeContactsTest, AFinWithoutThicknessHasNoInside) {
  TriangleMesh& mesh = m_bones[0].surface.mesh;
  mesh.vertices = {{0.0013, 0.0007, 0.0031}, {0.0117, 0.0023, -0.0011}, {0.0029, 0.0131, 0.0017}};
  mesh.triangles = {{0, 1, 2}, {2, 1, 0}};
  // Beyond each corner, on either side of the fin: the faces around cancel there, but for rounding.
  const Vec3 centre = (mesh.vertices[0] + mesh.vertices[1] + mesh.vertices[2]) / 3;
  const Vec3 across = (mesh.vertices[1] - mesh.vertices[0]).cross(mesh.vertices[2] - mesh.vertices[0]).normalized();
  for (const double side_m : {-2e-3, -1e-3, 1e-3, 2e-3}) {
    std::vector<Vec3> positions;
    for (const Vec3& corner : mesh.vertices) {
      positions.push_back(corner + 0.3 * (corner - centre) + side_m * across);
    }
    EXPECT_TRUE(contacts(positions, {{0, 0}, {0, 1}}).empty());
  }
}

}  // namespace
}  // namespace musclebench

#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <random>

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/base/temporary_folder.hpp"
#include "core/mesh/shapes.hpp"
#include "core/scene/attachment_area.hpp"
#include "core/scene/landmarks.hpp"

namespace musclebench {
namespace {

TEST(AttachmentArea, TheFarSideOfTheBoneDoesNotCount) {
  const TriangleMesh plate = make_box(Vec3(0.03, 0.03, 0.02), 6);
  const AttachmentArea area{{Vec3(-0.01, -0.01, 0.02), Vec3(0.01, -0.01, 0.02), Vec3(0.0, 0.012, 0.02)}, 0.005, 0.001};
  const std::vector<Vec3> nodes = {{0, 0, 0.021}, {0, 0, -0.021}, {0.02, 0, 0.021}, {0, -0.0105, 0.024}, {0, 0, 0.03}};
  EXPECT_EQ(nodes_over_area(nodes, plate, area), (std::vector<int>{0, 3}));
}

/// A square whose rim is exact: nodes just inside and just outside of what the margin adds, at sides and corners.
TEST(AttachmentArea, GrowsByItsMarginOnAllSides) {
  const TriangleMesh bone = make_box(Vec3(0.03, 0.03, 0.02), 6);
  const double margin_m = 0.004;
  const AttachmentArea area{
      {Vec3(-0.01, -0.01, 0.02), Vec3(0.01, -0.01, 0.02), Vec3(0.01, 0.01, 0.02), Vec3(-0.01, 0.01, 0.02)},
      0.001,
      margin_m};
  std::vector<Vec3> nodes;
  for (const double part : {0.99, 1.01}) {
    const double beside_m = 0.01 + part * margin_m;
    const double corner_m = 0.01 + part * margin_m / std::sqrt(2.0);
    nodes.insert(nodes.end(), {Vec3(beside_m, 0, 0.02), Vec3(-beside_m, 0.009, 0.02), Vec3(0, -beside_m, 0.02),
                               Vec3(corner_m, corner_m, 0.02)});
  }
  EXPECT_EQ(nodes_over_area(nodes, bone, area), (std::vector<int>{0, 1, 2, 3}));
}

TEST(AttachmentArea, BindsWithinItsDistanceFromTheBone) {
  const TriangleMesh bone = make_box(Vec3(0.03, 0.03, 0.02), 6);
  const AttachmentArea area{{Vec3(-0.01, -0.01, 0.02), Vec3(0.01, -0.01, 0.02), Vec3(0, 0.01, 0.02)}, 0.002, 0};
  const std::vector<Vec3> nodes = {Vec3(0, 0, 0.02 + 0.00198), Vec3(0, 0, 0.02 + 0.00202), Vec3(0, 0, 0.02 - 0.00198),
                                   Vec3(0, 0, 0.02 - 0.00202)};
  EXPECT_EQ(nodes_over_area(nodes, bone, area), (std::vector<int>{0, 2}));
}

/// Nodes that can't be bound are not asked about: what is bound is what a search over all nodes and triangles binds.
TEST(AttachmentArea, BindsWhatASearchOverEverythingBinds) {
  const TriangleMesh bone = make_sphere(0.03, 4);
  const TriangleBvh tree(bone);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-0.04, 0.04);
  std::vector<Vec3> nodes;
  for (int i = 0; i < 4000; ++i) {
    const double x = any(random);
    const double y = any(random);
    nodes.emplace_back(x, y, any(random));
  }
  for (const double distance_m : {0.0005, 0.004, 0.02}) {
    const AttachmentArea area{
        {Vec3(-0.01, -0.01, 0.026), Vec3(0.012, -0.01, 0.025), Vec3(0.0, 0.012, 0.027)}, distance_m, 0.002};
    std::vector<int> near;
    for (int node : nodes_over_area(nodes, bone, area)) near.push_back(node);
    std::vector<int> expected;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto closest = tree.closest_point(nodes[i], distance_m);
      if (!closest) continue;
      // Its closest point, taken for a node at no distance, is bound where the node is.
      AttachmentArea at_once = area;
      at_once.distance_m = 1e-9;
      if (!nodes_over_area(std::vector{closest->point}, bone, at_once).empty()) expected.push_back(static_cast<int>(i));
    }
    EXPECT_GT(near.size(), 2U) << distance_m;
    EXPECT_EQ(near, expected) << distance_m;
  }
}

/// A square in the plane z = 0: what counts is the distance from the square, on either side, with or without a bone.
TEST(AttachmentArea, OfAnOutlineNeedsNoBoneNearIt) {
  const TriangleMesh far_bone = make_box(Vec3(0.03, 0.03, 0.02), 2);
  AttachmentArea area{{Vec3(1, 1, 0), Vec3(1.02, 1, 0), Vec3(1.02, 1.02, 0), Vec3(1, 1.02, 0)}, 0.005, 0.001};
  const std::vector<Vec3> nodes = {Vec3(1.01, 1.01, 0.0049), Vec3(1.01, 1.01, -0.0049),  Vec3(1.01, 1.01, 0.0051),
                                   Vec3(1.01, 1.0209, 0),    Vec3(1.01, 1.0211, 0),      Vec3(0, 0, 0.02),
                                   Vec3(0.9991, 1.01, 0),    Vec3(0.9989, 1.01, -0.001), Vec3(1.01, 1.01, -0.0051)};
  EXPECT_TRUE(nodes_over_area(nodes, far_bone, area).empty());
  area.surface = AttachmentSurface::outline;
  EXPECT_EQ(nodes_over_area(nodes, far_bone, area), (std::vector<int>{0, 1, 3, 6}));
  const auto nearest = nearest_to_area(std::vector{Vec3(1.01, 1.01, 0.007)}, TriangleBvh(far_bone), area);
  ASSERT_TRUE(nearest);
  EXPECT_NEAR(nearest->to_surface_m, 0.007, 1e-15);
  EXPECT_EQ(nearest->beside_area_m, 0);
}

/// As each point would be asked about each node.
TEST(AttachmentArea, OfPointsHasNoAreaBetweenThem) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-0.02, 0.02);
  std::vector<Vec3> nodes, points;
  for (int i = 0; i < 500; ++i) nodes.emplace_back(any(random), any(random), 2 * any(random));
  for (int i = 0; i < 7; ++i) points.emplace_back(any(random), any(random), 2 * any(random));
  points.push_back(nodes[11]);
  const TriangleMesh bone = make_box(Vec3(0.03, 0.03, 0.02), 2);
  for (const double distance_m : {0.0, 0.002, 0.008}) {
    const AttachmentArea area{points, distance_m, 0, AttachmentSurface::points};
    std::vector<int> expected;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto is_near = [&](const Vec3& point) { return (point - nodes[i]).norm() <= distance_m; };
      if (std::ranges::any_of(points, is_near)) expected.push_back(static_cast<int>(i));
    }
    EXPECT_EQ(nodes_over_area(nodes, bone, area), expected);
    EXPECT_GE(expected.size(), distance_m > 0.005 ? 20U : 1U);
  }
  const auto nearest = nearest_to_area(std::vector<Vec3>{points[0] + Vec3(0.001, 0, 0), Vec3(1, 1, 1)},
                                       TriangleBvh(bone), {points, 0, 0, AttachmentSurface::points});
  ASSERT_TRUE(nearest);
  EXPECT_NEAR(nearest->to_surface_m, 0.001, 1e-15);
}

class LandmarkFile : public testing::Test {
 protected:
  [[nodiscard]] double first_x(const std::string& selector) {
    return read_landmark_outline(path(), selector).at(0).x();
  }
  [[nodiscard]] std::string error_of(const std::string& selector) {
    try {
      (void)read_landmark_outline(path(), selector);
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }

 private:
  [[nodiscard]] std::filesystem::path path() const {
    const auto file = m_folder / "landmarks.json";
    std::ofstream(file) << R"({"attachments": [
      {"muscle": "psoas", "role": "origin", "points_m": [[1, 0, 0]]},
      {"muscle": "psoas", "role": "origin", "points_m": [[2, 0, 0]]},
      {"muscle": "psoas", "role": "insertion", "points_m": [[3, 0, 0]]},
      {"muscle": "maximus", "role": "origin", "part": "sacrum", "points_m": [[4, 0, 0]]},
      {"muscle": "maximus", "role": "origin", "part": "hip_bone", "points_m": [[5, 0, 0]]}]})";
    return file;
  }

  TemporaryFolder m_folder;
};

TEST_F(LandmarkFile, IsAskedByMuscleRolePartAndNumber) {
  EXPECT_EQ(first_x("psoas/origin/1"), 1);
  EXPECT_EQ(first_x("psoas/origin/2"), 2);
  EXPECT_EQ(first_x("psoas/insertion"), 3);
  EXPECT_EQ(first_x("maximus/origin/hip_bone"), 5);
}

/// The first of several was taken without a word.
TEST_F(LandmarkFile, RefusesANameThatSeveralHave) {
  EXPECT_THAT(error_of("psoas/origin"), testing::HasSubstr("2 attachments 'psoas/origin'; name one of them, "
                                                           "psoas/origin/1 or psoas/origin/2"));
  EXPECT_THAT(error_of("maximus/origin"), testing::HasSubstr("maximus/origin/sacrum or maximus/origin/hip_bone"));
  EXPECT_THAT(error_of("psoas/orign/2"),
              testing::HasSubstr("has no attachment 'psoas/orign/2'; did you mean 'psoas/origin'?"));
}

}  // namespace
}  // namespace musclebench

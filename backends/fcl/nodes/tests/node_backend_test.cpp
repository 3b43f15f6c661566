#include "backends/fcl/nodes/node_backend.hpp"

#include <cmath>
#include <limits>
#include <numeric>

#include <gtest/gtest.h>

#include "backends/fcl/fcl_backend.hpp"
#include "backends/fcl/tests/moving_scene.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {
namespace {

const std::vector<RigidMotion> some_poses = {
    RigidMotion::about_axis(Vec3(1, -2, 0.5).normalized(), Vec3(0.1, 0.2, 0.3), 0.8)};

FclOptions by_distance() {
  FclOptions options;
  options.query = Query::node_distance;
  return options;
}

FclOptions by_collision(double node_radius_m) {
  FclOptions options;
  options.query = Query::node_collide;
  options.node_radius_m = node_radius_m;
  return options;
}

/// Contacts of points in the rest frame of a box of 2 x 4 x 6 cm.
std::vector<Contact> contacts_of(const std::vector<Vec3>& points, const FclOptions& options, int threads = 1,
                                 const std::vector<RigidMotion>& poses = some_poses) {
  const std::vector<Bone> bones = {make_bone("box", make_box({0.01, 0.02, 0.03}, 3))};
  TriangleMesh muscle;
  for (const Vec3& point : points) {
    muscle.vertices.push_back(poses[0].apply(point));
  }
  std::vector<int> nodes(points.size());
  std::iota(nodes.begin(), nodes.end(), 0);
  const auto backend = make_node_backend(options);
  backend->build(bones, muscle, threads);
  backend->update(poses, muscle.vertices);
  std::vector<Contact> contacts;
  backend->detect(muscle.vertices, nodes, contacts);
  return contacts;
}

TEST(NodeBackend, DistanceFindsNodesAtAnyDepth) {
  const auto found =
      contacts_of({{0.009, 0.001, 0.002}, {0.001, 0.0004, 0.0003}, {0.011, 0, 0}, {0.009, 0.021, 0}}, by_distance());
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].node, 0);
  EXPECT_NEAR(found[0].depth_m, 0.001, 1e-15);
  EXPECT_EQ(found[1].node, 1);
  EXPECT_NEAR(found[1].depth_m, 0.009, 1e-15);
  for (const Contact& contact : found) {
    EXPECT_LT((contact.normal - some_poses[0].apply_to_direction(Vec3::UnitX())).norm(), 1e-12);
  }
}

TEST(NodeBackend, ASphereFindsNodesUpToItsRadiusAndNoneOutside) {
  const std::vector<Vec3> points = {{0.0099, 0, 0}, {0.0091, 0, 0}, {0.0089, 0, 0}, {0.0101, 0, 0}, {0.001, 0, 0}};
  const auto found = contacts_of(points, by_collision(1e-3));
  ASSERT_EQ(found.size(), 2U) << "blind inside";
  EXPECT_EQ(found[0].node, 0);
  EXPECT_NEAR(found[0].depth_m, 1e-4, 1e-15);
  EXPECT_EQ(found[1].node, 1);
  EXPECT_NEAR(found[1].depth_m, 9e-4, 1e-15);
  EXPECT_EQ(contacts_of(points, by_collision(9.5e-3)).size(), 4U);
}

// Where a point lies in a triangle, FCL 0.7 leaves the distance unset (BerkeleyAutomation/python-fcl issue 54) and may
// name a triangle far away.
TEST(NodeBackend, ANodeOnTheSurfaceHasNoContact) {
  std::vector<Vec3> points;
  for (const double y : {-0.019, -0.013, 0.0, 0.0061, 0.02}) {
    for (const double z : {-0.03, -0.0217, 0.001, 0.0123, 0.029}) {
      points.insert(points.end(), {{0.01, y, z}, {-0.01, y, z}, {y / 2, 0.02, z}, {y / 2, z / 2, -0.03}});
    }
  }
  for (const FclOptions& options : {by_distance(), by_collision(1e-3)}) {
    EXPECT_TRUE(contacts_of(points, options, 1, {RigidMotion{}}).empty());
  }
}

TEST(NodeBackend, ThreadsDoNotChangeABit) {
  std::vector<Vec3> points;
  for (int i = 0; i < 400; ++i) {
    points.emplace_back(0.011 * std::sin(1.7 * i), 0.021 * std::sin(2.3 * i + 1), 0.031 * std::cos(3.1 * i));
  }
  for (const FclOptions& options : {by_distance(), by_collision(4e-3)}) {
    const auto one = contacts_of(points, options, 1);
    EXPECT_GT(one.size(), 100U);
    for (const int threads : {2, 5}) {
      const auto several = contacts_of(points, options, threads);
      ASSERT_EQ(several.size(), one.size());
      for (std::size_t i = 0; i < one.size(); ++i) {
        EXPECT_EQ(several[i].node, one[i].node);
        EXPECT_EQ(several[i].depth_m, one[i].depth_m);
        EXPECT_EQ(several[i].normal, one[i].normal);
      }
    }
  }
}

TEST(NodeBackend, PositionsThatAreNotFiniteHaveNoContact) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const FclOptions& options : {by_distance(), by_collision(5e-3)}) {
    EXPECT_EQ(contacts_of({{nan, 0, 0}, {0.008, 0, 0}, {0, infinity, 0}, {0, 0, 1e200}}, options).size(), 1U);
  }
}

TEST(NodeBackend, TheBackendAnswersForSubsetsAndWithoutBones) {
  const MovingScene scene;
  const auto backend =
      make_fcl_backend(Parameters(fcl_parameters(), {{"query", std::string("node_distance")}}, "test"));
  EXPECT_TRUE(backend->capabilities().point_queries);
  EXPECT_TRUE(backend->capabilities().depth);
  std::vector<Contact> contacts;
  backend->build({}, scene.muscle, 1);
  backend->update({}, scene.positions(0));
  backend->detect(scene.positions(0), std::vector<int>{0, 1}, contacts);
  EXPECT_TRUE(contacts.empty());
  backend->build(scene.bones, scene.muscle, 1);
  EXPECT_LT(backend->answer_bound(0).missed_depth_m, 1e-12);
  EXPECT_GT(backend->structure_bytes(), 100'000U);
  backend->update(scene.poses(0), scene.positions(0));
  std::vector<int> nodes(scene.muscle.vertices.size());
  std::iota(nodes.begin(), nodes.end(), 0);
  backend->detect(scene.positions(0), nodes, contacts);
  ASSERT_FALSE(contacts.empty());
  const std::vector<int> one = {contacts.back().node};
  const Contact expected = contacts.back();
  backend->detect(scene.positions(0), one, contacts);
  ASSERT_FALSE(contacts.empty());
  EXPECT_EQ(contacts.back().depth_m, expected.depth_m);
}

TEST(NodeBackend, RefusalsNameWhatIsPossible) {
  const auto message = [](const std::map<std::string, ParameterValue>& given) -> std::string {
    try {
      make_fcl_backend(Parameters(fcl_parameters(), given, "test"));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const auto no_distance = message({{"query", std::string("node_distance")}, {"bounding_volume", std::string("OBB")}});
  EXPECT_NE(no_distance.find("unsupported"), std::string::npos) << no_distance;
  EXPECT_NE(no_distance.find("OBBRSS, RSS or kIOS"), std::string::npos) << no_distance;
  EXPECT_NE(message({{"query", std::string("node_collide")}, {"model", std::string("update")}}).find("fcl: model"),
            std::string::npos);
  EXPECT_NE(message({{"query", std::string("node_distance")}, {"manager", std::string("none")}}).find("fcl: manager"),
            std::string::npos);
  EXPECT_NE(message({{"node_radius_m", 1e-3}}).find("node_collide"), std::string::npos);
  EXPECT_EQ(message({{"clearance_cache", std::string("off")}}), "");
}

}  // namespace
}  // namespace musclebench

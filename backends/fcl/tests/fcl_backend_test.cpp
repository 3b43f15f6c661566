#include "backends/fcl/fcl_backend.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include <gtest/gtest.h>

#include "backends/fcl/tests/intersecting_triangles.hpp"
#include "core/base/input_error.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

using Given = std::map<std::string, ParameterValue>;

std::vector<int> all_nodes(std::size_t count) {
  std::vector<int> nodes(count);
  std::iota(nodes.begin(), nodes.end(), 0);
  return nodes;
}

std::unique_ptr<CollisionBackend> make_backend(const Given& given = {}) {
  return make_fcl_backend(Parameters(fcl_parameters(), given, "test"));
}

std::vector<Contact> contacts_of(const std::vector<Bone>& bones, const TriangleMesh& muscle,
                                 const std::vector<RigidMotion>& poses, const std::vector<Vec3>& positions,
                                 const Given& given = {}) {
  const auto backend = make_backend(given);
  backend->build(bones, muscle, 1);
  backend->update(poses, positions);
  std::vector<Contact> contacts;
  backend->detect(positions, all_nodes(positions.size()), contacts);
  return contacts;
}

void expect_equal(const std::vector<Contact>& a, const std::vector<Contact>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].node, b[i].node);
    EXPECT_EQ(a[i].bone, b[i].bone);
    EXPECT_EQ(a[i].depth_m, b[i].depth_m);
    EXPECT_EQ(a[i].normal, b[i].normal);
  }
}

/// A ball pressed by 12 mm into the upper face (z = 0.05 in its rest frame) of a turned box.
struct PressedBall {
  std::vector<Bone> bones = {make_bone("box", make_box({0.2, 0.2, 0.05}, 9))};
  TriangleMesh muscle = make_sphere(0.04, 4);
  std::vector<RigidMotion> poses = {RigidMotion::about_axis(Vec3(1, -2, 0.5).normalized(), Vec3(0.1, 0.2, 0.3), 0.8)};
  std::vector<Vec3> positions;

  explicit PressedBall(double press_m = 0.012) {
    for (const Vec3& vertex : muscle.vertices) {
      positions.push_back(poses[0].apply(vertex + Vec3(0.0123, -0.0234, 0.05 + 0.04 - press_m)));
    }
  }
  double depth(int node) const { return 0.05 - poses[0].apply_inverse(positions[static_cast<std::size_t>(node)]).z(); }
  std::set<int> nodes_of_cutting_triangles() const {
    std::set<int> nodes;
    for (const auto& [triangle, ignored] :
         intersecting_pairs(positions, muscle.triangles, bones[0].surface.mesh, poses[0])) {
      const Triangle& corners = muscle.triangles[static_cast<std::size_t>(triangle)];
      nodes.insert(corners.begin(), corners.end());
    }
    return nodes;
  }
};

TEST(FclBackend, FindsTheInnerNodesOfTheTrianglesThatCutTheBone) {
  const PressedBall scene;
  std::set<int> expected;
  for (const int node : scene.nodes_of_cutting_triangles()) {
    if (scene.depth(node) > 0) {
      expected.insert(node);
    }
  }
  EXPECT_GT(expected.size(), 40U);
  const auto contacts = contacts_of(scene.bones, scene.muscle, scene.poses, scene.positions);
  std::set<int> found;
  for (const Contact& contact : contacts) {
    found.insert(contact.node);
    // The distance to some of the bone's triangles: never less than the depth, and hardly more near the surface.
    EXPECT_GE(contact.depth_m, scene.depth(contact.node) - 1e-15);
    EXPECT_LE(contact.depth_m, scene.depth(contact.node) + 1e-3);
    EXPECT_LT((contact.normal - scene.poses[0].apply_to_direction(Vec3::UnitZ())).norm(), 1e-12);
  }
  EXPECT_EQ(found, expected);
}

TEST(FclBackend, MissesNodesDeepInside) {
  const PressedBall scene(0.03);
  const auto contacts = contacts_of(scene.bones, scene.muscle, scene.poses, scene.positions);
  const auto near_surface = scene.nodes_of_cutting_triangles();
  int inside = 0;
  int deepest = 0;
  for (int node = 0; node < static_cast<int>(scene.positions.size()); ++node) {
    inside += scene.depth(node) > 0 ? 1 : 0;
    deepest = scene.depth(node) > scene.depth(deepest) ? node : deepest;
  }
  EXPECT_GT(contacts.size(), 0U);
  EXPECT_LT(contacts.size() * 3, static_cast<std::size_t>(inside));
  for (const Contact& contact : contacts) {
    EXPECT_NE(contact.node, deepest);
    EXPECT_TRUE(near_surface.contains(contact.node));
  }
}

TEST(FclBackend, SaysWhatItCanDo) {
  const Capabilities can = make_backend()->capabilities();
  EXPECT_TRUE(can.depth);
  EXPECT_FALSE(can.point_queries);
}

/// A node hangs on a triangle that cuts the bone: it is no farther from it than the longest edge.
TEST(FclBackend, ReportsNoNodeFartherAwayThanTheLongestEdge) {
  const auto backend = make_backend();
  const std::vector<Bone> bones = {make_bone("ball", make_sphere(0.02, 2))};
  const TriangleMesh block = make_box({0.03, 0.04, 0.05}, 1);
  backend->build(bones, block, 1);
  EXPECT_NEAR(backend->answer_bound(0).false_distance_m, std::hypot(0.08, 0.1), 1e-12);
}

TEST(FclBackend, EmptyWhenApartOrWhollyInsideOrWithoutBones) {
  const PressedBall scene;
  std::vector<Vec3> apart = scene.positions;
  for (Vec3& position : apart) {
    position += scene.poses[0].apply_to_direction(Vec3(0, 0, 0.0121));
  }
  EXPECT_TRUE(contacts_of(scene.bones, scene.muscle, scene.poses, apart).empty());
  std::vector<Vec3> swallowed;
  for (const Vec3& vertex : scene.muscle.vertices) {
    swallowed.push_back(scene.poses[0].apply(vertex));
  }
  EXPECT_TRUE(contacts_of(scene.bones, scene.muscle, scene.poses, swallowed).empty());
  EXPECT_TRUE(contacts_of({}, scene.muscle, {}, scene.positions).empty());
  EXPECT_TRUE(
      contacts_of({}, scene.muscle, {}, scene.positions, {{"manager", std::string("sweep_and_prune")}}).empty());
}

TEST(FclBackend, GivesTheSameAnswerTwice) {
  const PressedBall scene;
  const auto backend = make_backend();
  backend->build(scene.bones, scene.muscle, 1);
  backend->update(scene.poses, scene.positions);
  const auto nodes = all_nodes(scene.positions.size());
  std::vector<Contact> first;
  std::vector<Contact> second;
  backend->detect(scene.positions, nodes, first);
  backend->detect(scene.positions, nodes, second);
  EXPECT_FALSE(first.empty());
  expect_equal(first, second);
  backend->update(scene.poses, scene.positions);
  backend->detect(scene.positions, nodes, second);
  expect_equal(first, second);
  expect_equal(first, contacts_of(scene.bones, scene.muscle, scene.poses, scene.positions));
}

TEST(FclBackend, EveryOptionGivesTheSameContactsButOne) {
  const PressedBall scene;
  const auto expected = contacts_of(scene.bones, scene.muscle, scene.poses, scene.positions);
  for (const char* volume : {"OBBRSS", "OBB", "RSS", "kIOS", "AABB", "KDOP24"}) {
    for (const char* update : {"refit", "refit_top_down", "rebuild"}) {
      for (const char* manager : {"dynamic_aabb_tree", "sweep_and_prune", "none"}) {
        const Given given = {{"bounding_volume", std::string(volume)},
                             {"update", std::string(update)},
                             {"manager", std::string(manager)},
                             {"model", std::string(update[2] == 'f' ? "update" : "replace")}};
        SCOPED_TRACE(std::string(volume) + " " + update + " " + manager);
        const auto found = contacts_of(scene.bones, scene.muscle, scene.poses, scene.positions, given);
        if (std::string(volume) == "RSS" && std::string(update) == "refit") {
          EXPECT_LT(found.size(), expected.size()) << "FCL 0.7 loses pairs here; has it been repaired?";
        } else {
          expect_equal(found, expected);
        }
      }
    }
  }
}

TEST(FclBackend, MotionOfEverythingMovesTheAnswer) {
  const PressedBall scene;
  const auto before = contacts_of(scene.bones, scene.muscle, scene.poses, scene.positions);
  const RigidMotion motion = RigidMotion::about_axis(Vec3(3, 1, -2).normalized(), Vec3(0.5, -0.2, 0.1), 2.1);
  std::vector<Vec3> moved;
  for (const Vec3& position : scene.positions) {
    moved.push_back(motion.apply(position));
  }
  const auto after = contacts_of(scene.bones, scene.muscle, {motion * scene.poses[0]}, moved);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_EQ(after[i].node, before[i].node);
    EXPECT_NEAR(after[i].depth_m, before[i].depth_m, 1e-14);
    EXPECT_LT((after[i].normal - motion.apply_to_direction(before[i].normal)).norm(), 1e-12);
  }
}

TEST(FclBackend, AnswersOnlyForTheNodesAskedFor) {
  const PressedBall scene;
  const auto all = contacts_of(scene.bones, scene.muscle, scene.poses, scene.positions);
  std::vector<int> even;
  std::vector<Contact> expected;
  for (int node = 0; node < static_cast<int>(scene.positions.size()); node += 2) {
    even.push_back(node);
  }
  std::copy_if(all.begin(), all.end(), std::back_inserter(expected), [](const Contact& c) { return c.node % 2 == 0; });
  const auto backend = make_backend();
  backend->build(scene.bones, scene.muscle, 1);
  backend->update(scene.poses, scene.positions);
  std::vector<Contact> found;
  backend->detect(scene.positions, even, found);
  EXPECT_LT(found.size(), all.size());
  EXPECT_GT(found.size(), 0U);
  expect_equal(found, expected);
  backend->detect(scene.positions, {}, found);
  EXPECT_TRUE(found.empty());
}

TEST(FclBackend, OrdersByBoneThenNodeAndKeepsBonesApart) {
  PressedBall scene;
  const auto alone = contacts_of(scene.bones, scene.muscle, scene.poses, scene.positions);
  // A second box comes from the other side, in front of the first, and a third is far away.
  const std::vector<Bone> bones = {make_bone("far", make_sphere(0.01, 1)),
                                   make_bone("above", make_box({0.2, 0.2, 0.05}, 7)), scene.bones[0]};
  const RigidMotion above{Mat3::Identity(), Vec3(0.003, 0.001, 0.05 + 0.04 - 0.012 + 0.08)};
  const std::vector<RigidMotion> poses = {{Mat3::Identity(), Vec3(3, 3, 3)}, scene.poses[0] * above, scene.poses[0]};
  const auto contacts = contacts_of(bones, scene.muscle, poses, scene.positions);
  EXPECT_TRUE(std::is_sorted(contacts.begin(), contacts.end(), [](const Contact& a, const Contact& b) {
    return std::pair(a.bone, a.node) < std::pair(b.bone, b.node);
  }));
  std::vector<Contact> of_last;
  std::size_t of_above = 0;
  for (Contact contact : contacts) {
    EXPECT_NE(contact.bone, 0);
    of_above += contact.bone == 1 ? 1 : 0;
    if (contact.bone == 2) {
      contact.bone = 0;
      of_last.push_back(contact);
    }
  }
  EXPECT_GT(of_above, 10U);
  expect_equal(of_last, alone);
}

TEST(FclBackend, PermutedVerticesGiveTheSameSet) {
  const PressedBall scene;
  const auto count = static_cast<int>(scene.positions.size());
  const auto renamed = [&](int node) { return count - 1 - node; };
  TriangleMesh muscle = scene.muscle;
  std::reverse(muscle.vertices.begin(), muscle.vertices.end());
  std::reverse(muscle.triangles.begin(), muscle.triangles.end());
  for (Triangle& triangle : muscle.triangles) {
    std::transform(triangle.begin(), triangle.end(), triangle.begin(), renamed);
  }
  std::vector<Vec3> positions(scene.positions.rbegin(), scene.positions.rend());
  auto found = contacts_of(scene.bones, muscle, scene.poses, positions);
  for (Contact& contact : found) {
    contact.node = renamed(contact.node);
  }
  std::reverse(found.begin(), found.end());
  expect_equal(found, contacts_of(scene.bones, scene.muscle, scene.poses, scene.positions));
}

TEST(FclBackend, TrianglesWithoutAreaAtRestChangeNothing) {
  const PressedBall scene;
  TriangleMesh muscle = scene.muscle;
  for (int node = 0; node + 5 < static_cast<int>(muscle.vertices.size()); node += 5) {
    muscle.triangles.push_back({node, node, node + 5});
  }
  expect_equal(contacts_of(scene.bones, muscle, scene.poses, scene.positions),
               contacts_of(scene.bones, scene.muscle, scene.poses, scene.positions));
  muscle.triangles = {{0, 0, 1}, {2, 3, 2}};
  EXPECT_THROW(contacts_of(scene.bones, muscle, scene.poses, scene.positions), InputError);
}

TEST(FclBackend, PositionsThatAreNotFiniteHaveNoContacts) {
  const PressedBall scene;
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e200}) {
    const auto backend = make_backend();
    backend->build(scene.bones, scene.muscle, 1);
    std::vector<Vec3> positions = scene.positions;
    positions[0].x() = bad;  // one is enough: the others would still collide
    std::vector<Contact> contacts;
    const auto nodes = all_nodes(positions.size());
    backend->update(scene.poses, positions);
    backend->detect(positions, nodes, contacts);
    EXPECT_TRUE(contacts.empty());
    backend->update(scene.poses, scene.positions);
    backend->detect(scene.positions, nodes, contacts);
    expect_equal(contacts, contacts_of(scene.bones, scene.muscle, scene.poses, scene.positions));
  }
}

TEST(FclBackend, CountsItsBytes) {
  const PressedBall scene;
  const auto bytes = [&](const Given& given) {
    const auto backend = make_backend(given);
    backend->build(scene.bones, scene.muscle, 1);
    const std::size_t before = backend->structure_bytes();
    backend->update(scene.poses, scene.positions);
    std::vector<Contact> contacts;
    backend->detect(scene.positions, all_nodes(scene.positions.size()), contacts);
    EXPECT_EQ(backend->structure_bytes(), before);
    return before;
  };
  const std::size_t triangles = scene.muscle.triangles.size() + scene.bones[0].surface.mesh.triangles.size();
  const std::size_t obbrss = bytes({});
  EXPECT_EQ(obbrss, bytes({}));
  EXPECT_GT(obbrss, triangles * 2 * 200);
  EXPECT_LT(obbrss, triangles * 2 * 500);
  EXPECT_LT(bytes({{"bounding_volume", std::string("OBB")}}), obbrss);
  EXPECT_EQ(bytes({{"model", std::string("update")}}), obbrss + scene.positions.size() * sizeof(Vec3));
}

}  // namespace
}  // namespace musclebench

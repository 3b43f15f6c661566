#include "core/contact/reach_watch.hpp"

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "core/contact/tests/shape_backend.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

const Eigen::AlignedBox3d unit_box(Vec3(-1, -1, -1), Vec3(1, 1, 1));
const double slack_m = 0.01 * unit_box.diagonal().norm();

/// Bones 1 and 3, whose contacts reach 0.5 m beyond their boxes; 3 is turned by 45 degrees about z and moved.
ReachWatch watch_of_two() {
  ReachWatch watch;
  watch.add(1, unit_box, 0.5);
  watch.add(3, unit_box, 0.5);
  std::vector<RigidMotion> poses(4);
  poses[3] = RigidMotion{Mat3::Identity(), Vec3(10, 0, 0)} *
             RigidMotion::about_axis(Vec3::UnitZ(), Vec3::Zero(), std::numbers::pi / 4);
  watch.move(poses);
  return watch;
}

std::vector<int> near_node(const Vec3& position) {
  ReachWatch watch = watch_of_two();
  const std::vector<Vec3> positions = {Vec3(0, 0, 0), position};
  const auto near = watch.find_near(positions, std::vector<int>{1});
  return {near.begin(), near.end()};
}

TEST(ReachWatch, SeesANodeWithinReachOfABoneInItsPose) {
  EXPECT_EQ(near_node(Vec3(1.49, 0, 0)), std::vector{1});
  EXPECT_EQ(near_node(Vec3(1.51 + slack_m, 0, 0)), std::vector<int>{});
  EXPECT_EQ(near_node(Vec3(0, -1.49, 1.49)), std::vector{1});
  // The corner of the turned box, and a point of its box in the world that is outside.
  EXPECT_EQ(near_node(Vec3(10 - 1.49 * std::numbers::sqrt2, 0, 0)), std::vector{3});
  EXPECT_EQ(near_node(Vec3(8.2, 1.8, 0)), std::vector<int>{});
}

TEST(ReachWatch, NodesThatAreNotAskedAboutAndPositionsThatAreNoneBringNothingBack) {
  ReachWatch watch = watch_of_two();
  const std::vector<Vec3> positions = {Vec3(0, 0, 0), Vec3(5, 0, 0), Vec3::Constant(std::nan("")),
                                       Vec3::Constant(std::numeric_limits<double>::infinity())};
  EXPECT_TRUE(watch.find_near(positions, std::vector<int>{1, 2, 3}).empty());
  EXPECT_EQ(watch.find_near(positions, std::vector<int>{0, 1, 2, 3}).size(), 1U);
}

TEST(ReachWatch, SeesATriangleWithAllItsCornersOutside) {
  ReachWatch watch = watch_of_two();
  const std::vector<Vec3> positions = {Vec3(-3, 0, 0), Vec3(3, 0, 0.1), Vec3(3, 0.1, 0), Vec3(0, 5, 0), Vec3(3, 5, 0)};
  EXPECT_TRUE(watch.find_near(positions, std::vector<int>{0, 1, 2}).empty());
  const auto near = watch.find_near(positions, std::vector<Triangle>{{0, 1, 2}});
  EXPECT_EQ(std::vector<int>(near.begin(), near.end()), std::vector{1});
  EXPECT_TRUE(watch.find_near(positions, std::vector<Triangle>{{1, 2, 4}}).empty());
}

TEST(ReachWatch, CountsUntilTheBoneIsBack) {
  ReachWatch watch = watch_of_two();
  watch.count_saved_queries(10);
  watch.bring_back(3).build_ns = 7;
  watch.count_saved_queries(5);
  ASSERT_EQ(watch.bones().size(), 2U);
  EXPECT_EQ(watch.bones()[0].saved_queries, 15);
  EXPECT_EQ(watch.bones()[1].saved_queries, 10);
  EXPECT_TRUE(watch.watches(1));
  EXPECT_FALSE(watch.watches(3));
  EXPECT_FALSE(watch.bones()[0].is_back);
  EXPECT_TRUE(watch.bones()[1].is_back);
  EXPECT_EQ(watch.bones()[1].build_ns, 7);
  watch.bring_back(1);
  EXPECT_FALSE(watch.is_active());
}

/// Has a ball of radius 1 for each bone, and notes over which it builds.
class NotingBackend final : public CollisionBackend {
 public:
  explicit NotingBackend(bool point_queries, double reach_m) : m_point_queries(point_queries), m_reach_m(reach_m) {}
  std::vector<std::size_t> built;

  [[nodiscard]] Capabilities capabilities() const override { return {true, m_point_queries}; }
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override { return {}; }
  [[nodiscard]] std::size_t structure_bytes() const override { return 0; }
  [[nodiscard]] double contact_reach_m(const Bone& /*bone*/) const override { return m_reach_m; }

 private:
  void do_build() override {
    for (std::size_t bone = 0; bone < bones().size(); ++bone) {
      if (!is_pruned(bone)) built.push_back(bone);
    }
  }
  void do_bring_back(std::size_t bone) override { built.push_back(bone); }
  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    for (const std::size_t bone : built) {
      for (const int node : nodes) {
        if (poses()[bone].apply_inverse(positions[static_cast<std::size_t>(node)]).norm() < 1) {
          contacts.push_back({node, static_cast<int>(bone)});
        }
      }
    }
  }

  bool m_point_queries;
  double m_reach_m;
};

class PrunedBones : public testing::Test {
 protected:
  /// Bone 1 is expected untouched and stands 10 m away.
  std::unique_ptr<NotingBackend> made(bool point_queries, double reach_m = 0) {
    auto backend = std::make_unique<NotingBackend>(point_queries, reach_m);
    backend->expect_within({unbounded_box(), Eigen::AlignedBox3d()});
    backend->build(m_bones, m_muscle, 1);
    return backend;
  }
  std::vector<Contact> contacts(CollisionBackend& backend, double bone_at_m, const std::vector<int>& nodes) {
    const std::vector<RigidMotion> poses = {RigidMotion{}, {Mat3::Identity(), Vec3(bone_at_m, 0, 0)}};
    std::vector<Contact> found;
    backend.update(poses, m_muscle.vertices);
    backend.detect(m_muscle.vertices, nodes, found);
    return found;
  }

  TriangleMesh m_muscle{{Vec3(3, 0, 0), Vec3(3, 0.5, 0), Vec3(3.2, 0, 0)}, {{0, 1, 2}}};
  std::vector<Bone> m_bones = {{"left", {make_sphere(1, 1), true, {}}}, {"right", {make_sphere(1, 1), true, {}}}};
};

TEST_F(PrunedBones, AreBuiltWhenTheyMoveIntoReachAndAnswerInThatDetection) {
  const auto backend = made(true);
  EXPECT_EQ(backend->built, std::vector<std::size_t>{0});
  EXPECT_TRUE(contacts(*backend, 10, {0, 1, 2}).empty());
  EXPECT_EQ(backend->built, std::vector<std::size_t>{0});
  EXPECT_EQ(contacts(*backend, 3.5, {0, 1, 2}).size(), 3U);
  EXPECT_EQ(backend->built, (std::vector<std::size_t>{0, 1}));
  contacts(*backend, 3.5, {0, 1, 2});
  EXPECT_EQ(backend->built, (std::vector<std::size_t>{0, 1})) << "once";
  ASSERT_EQ(backend->pruned_bones().size(), 1U);
  EXPECT_EQ(backend->pruned_bones()[0].bone, 1);
  EXPECT_EQ(backend->pruned_bones()[0].saved_queries, 3);
  EXPECT_TRUE(backend->pruned_bones()[0].is_back);
}

TEST_F(PrunedBones, AreWatchedByNodesThatAreAskedAboutAndByAllTriangles) {
  const auto by_nodes = made(true);
  contacts(*by_nodes, 4.1, {0, 1});
  EXPECT_EQ(by_nodes->built, std::vector<std::size_t>{0}) << "node 2 alone is near";
  const auto by_triangles = made(false);
  contacts(*by_triangles, 4.1, {0, 1});
  EXPECT_EQ(by_triangles->built, (std::vector<std::size_t>{0, 1}));
}

TEST_F(PrunedBones, AreNoneWhereItIsNotKnownHowFarContactsReach) {
  const auto backend = made(true, std::numeric_limits<double>::infinity());
  EXPECT_EQ(backend->built, (std::vector<std::size_t>{0, 1}));
  EXPECT_TRUE(backend->pruned_bones().empty());
}

}  // namespace
}  // namespace musclebench

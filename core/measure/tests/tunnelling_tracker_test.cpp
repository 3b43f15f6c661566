#include "core/measure/tunnelling_tracker.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/referee/tests/test_bones.hpp"

namespace musclebench {
namespace {

/// One node among bones.
class Walk {
 public:
  explicit Walk(const std::vector<TriangleMesh>& meshes)
      : m_bones(bones(meshes)), m_referee(m_bones, 1), m_tracker(static_cast<int>(meshes.size()), 1) {}

  /// Tunnelled nodes after the node went there.
  int to(const Vec3& point, const RigidMotion& pose = {}) {
    const std::vector<RigidMotion> poses(m_bones.size(), pose);
    const std::vector<Vec3> positions{point};
    const std::vector<int> nodes{0};
    m_referee.judge(poses, positions, nodes, m_truth);
    return m_tracker.update(m_referee, poses, positions, nodes, m_truth);
  }
  /// After the last of several points.
  int along(const std::vector<Vec3>& points) {
    int tunnelled = 0;
    for (const Vec3& point : points) tunnelled = to(point);
    return tunnelled;
  }
  [[nodiscard]] long work() const { return m_tracker.last_work(); }

 private:
  static std::vector<Bone> bones(const std::vector<TriangleMesh>& meshes) {
    std::vector<Bone> result;
    for (const TriangleMesh& mesh : meshes) result.push_back(bone_of(mesh));
    return result;
  }

  std::vector<Bone> m_bones;
  Referee m_referee;
  TunnellingTracker m_tracker;
  std::vector<Contact> m_truth;
};

TriangleMesh plate() { return make_box({1, 1, 0.01}, 3); }

TEST(TunnellingTracker, ThroughAPlateInOneFrame) {
  EXPECT_EQ(Walk({plate()}).along({{0.1, 0.2, 0.5}, {0.12, 0.25, -0.5}}), 1);
}

TEST(TunnellingTracker, WorkIsCounted) {
  Walk walk({plate()});
  walk.to({0.1, 0.2, 0.5});
  EXPECT_EQ(walk.work(), 0) << "a node that is seen first has no path";
  walk.to({0.12, 0.25, -0.5});
  EXPECT_GT(walk.work(), 0);
  walk.to({0.12, 0.25, -0.5});
  EXPECT_EQ(walk.work(), 0) << "a node far away that rests is not followed";
}

TEST(TunnellingTracker, ThroughAPlateInManyFrames) {
  Walk walk({plate()});
  EXPECT_EQ(walk.to({0.1, 0.2, 0.5}), 0);
  EXPECT_EQ(walk.to({0.1, 0.2, 0.005}), 0);  // inside, not yet through
  EXPECT_EQ(walk.to({0.1, 0.3, -0.004}), 0);
  EXPECT_EQ(walk.to({0.1, 0.3, -0.02}), 1);
  EXPECT_EQ(walk.to({0.1, 0.3, -3}), 1);
}

TEST(TunnellingTracker, ThereAndBack) {
  EXPECT_EQ(Walk({plate()}).along({{0, 0.1, 0.5}, {0, 0.1, -0.5}, {0, 0.1, 0.4}}), 0);
  EXPECT_EQ(Walk({plate()}).along({{0, 0.1, 0.5}, {0, 0.1, -0.5}, {0.1, 0.1, 0}, {0.1, 0.1, 0.5}}), 0);
  EXPECT_EQ(Walk({plate()}).along({{0, 0.1, 0.5}, {0, 0.1, -0.5}, {0, 0.1, 0.4}, {0, 0.1, -0.4}}), 1);
}

TEST(TunnellingTracker, DipsInAndComesBack) {
  EXPECT_EQ(Walk({plate()}).along({{0, 0.1, 0.5}, {0.3, 0.1, -0.005}, {0.6, 0.1, 0.02}}), 0);
  EXPECT_EQ(Walk({make_sphere(1, 3)}).along({{0, 0, 1.1}, {0.1, 0, 0.9}, {0.2, 0, 1.1}}), 0);
}

TEST(TunnellingTracker, ThroughASphere) {
  EXPECT_EQ(Walk({make_sphere(1, 3)}).along({{0, 0.2, 2}, {0, 0.2, -2}}), 1);
  EXPECT_EQ(Walk({make_sphere(1, 3)}).along({{0, 0.2, 2}, {0, 0.2, 0.3}, {0.1, 0.2, -0.3}, {0, 0.2, -2}}), 1);
  EXPECT_EQ(Walk({make_sphere(1, 3)}).along({{-2, 0, 0.95}, {2, 0.2, 0.9}}), 0);  // cuts a cap off
}

TEST(TunnellingTracker, CuttingACornerIsNone) {
  const TriangleMesh box = make_box({1, 1, 1}, 2);
  EXPECT_EQ(Walk({box}).along({{0.9, 0.1, 1.05}, {1.05, 0.1, 0.9}}), 0);
  EXPECT_EQ(Walk({box}).along({{0.9, 0.1, 1.05}, {0.98, 0.1, 0.97}, {1.05, 0.1, 0.9}}), 0);
  const RigidMotion motion = some_motion();
  Walk walk({moved(box, motion)});
  walk.to(motion.apply({0.9, 0.1, 1.05}));
  EXPECT_EQ(walk.to(motion.apply({1.05, 0.1, 0.9})), 0);
}

TEST(TunnellingTracker, CuttingASharpEdgeByALittleIsNone) {
  const TriangleMesh wedge = make_roof(0.1, 1, 2);
  const double little = TunnellingTracker::grazing_depth * 4;
  const double much = 0.2;
  for (const double sunk : {little, much}) {
    const Vec3 from(-0.2, 0.1, -sunk);
    const Vec3 to(0.2, 0.1, -sunk);
    EXPECT_EQ(Walk({wedge}).along({from, to}), sunk == much ? 1 : 0);
    EXPECT_EQ(Walk({wedge}).along({from, {0, 0.1, -sunk}, to}), sunk == much ? 1 : 0);
  }
}

TEST(TunnellingTracker, PassingByIsNone) {
  EXPECT_EQ(Walk({plate()}).along({{0.9, 0, 0.3}, {1.3, 0, 0}, {0.9, 0, -0.3}}), 0);
}

TEST(TunnellingTracker, TheBoneMoves) {
  Walk walk({plate()});
  const Vec3 node(0.1, 0.2, 0.5);
  EXPECT_EQ(walk.to(node), 0);
  EXPECT_EQ(walk.to(node, {Mat3::Identity(), {0, 0, 0.6}}), 1);
  EXPECT_EQ(walk.to(node, {Mat3::Identity(), {0, 0, 0.3}}), 0);
}

TEST(TunnellingTracker, BothMoveTogether) {
  Walk walk({plate()});
  walk.to({0.1, 0.2, 0.5});
  EXPECT_EQ(walk.to(some_motion().apply({0.1, 0.2, 0.5}), some_motion()), 0);
}

TEST(TunnellingTracker, ANodeSeenInsideEnteredWhereItIsClosest) {
  EXPECT_EQ(Walk({plate()}).along({{0, 0.1, 0.006}, {0, 0.1, 0.02}}), 0);
  EXPECT_EQ(Walk({plate()}).along({{0, 0.1, 0.006}, {0, 0.1, -0.02}}), 1);
}

/// Where a response has put it, on the surface, the node counts as outside, whatever its last bit says.
TEST(TunnellingTracker, ThroughAPlateFromOnItsSurface) {
  for (const double off : {-1e-14, 0.0, 1e-14}) {
    EXPECT_EQ(Walk({plate()}).along({{0, 0.1, 0.02}, {0, 0.1, 0.01 + off}, {0, 0.1, -0.5}}), 1) << off;
    EXPECT_EQ(Walk({plate()}).along({{0, 0.1, 0.02}, {0, 0.1, 0.01 + off}, {0, 0.1, 0.5}}), 0) << off;
    EXPECT_EQ(Walk({plate()}).along({{0, 0.1, 0.5}, {0, 0.1, -0.01 + off}}), 1) << off;
  }
}

TEST(TunnellingTracker, FacesInsideTheBoneAreNone) {
  TriangleMesh bone = make_box({1, 1, 1}, 1);
  append(bone, moved(make_box({1, 1, 1}, 1), Vec3(0, 0, 1.5)));
  EXPECT_EQ(Walk({bone}).along({{0.1, 0.2, 4}, {0.1, 0.2, 0.8}, {0.1, 0.2, 0}, {0.1, 0.2, 2}, {0.1, 0.2, 4}}), 0);
  EXPECT_EQ(Walk({bone}).along({{0.1, 0.2, 4}, {0.1, 0.2, 0.8}, {0.1, 0.2, -4}}), 1);
  EXPECT_EQ(Walk({bone}).along({{0.1, 0.2, 4}, {0.1, 0.2, -4}}), 1);
}

TEST(TunnellingTracker, CountsANodeOnceForSeveralBones) {
  EXPECT_EQ(Walk({plate(), moved(plate(), Vec3(0, 0, -0.1))}).along({{0, 0.1, 0.5}, {0, 0.1, -0.5}}), 1);
}

TEST(TunnellingTracker, ThroughAnEdgeOfTheMesh) {
  // The diagonals and the grid of make_box: x = y, and multiples of 2/3.
  EXPECT_EQ(Walk({plate()}).along({{1.0 / 3, 0.5, 0.5}, {1.0 / 3, 0.5, -0.5}}), 1);
  EXPECT_EQ(Walk({plate()}).along({{0.5, 0.5, 0.5}, {0.5, 0.5, -0.5}}), 1);
  EXPECT_EQ(Walk({plate()}).along({{0, 0, 0.5}, {0, 0, 0}, {0, 0, -0.5}}), 1);
}

TEST(TunnellingTracker, APositionThatIsNotFiniteChangesNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(Walk({plate()}).along({{0, 0.1, 0.5}, {nan, 0, 0}, {0, 0.1, -0.5}, {0, nan, 0}}), 1);
}

}  // namespace
}  // namespace musclebench

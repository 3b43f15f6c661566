#include "core/measure/answer_error.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/measure/depth_error.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

constexpr double half_size_m = 0.5;
constexpr double band_m = 0.01;

/// A cube, whose distance is exact: above its top face z - 0.5, and so far inside that other faces are farther.
class AnswerError : public testing::Test {
 protected:
  AnswerError()
      : m_bones{{"cube", {make_box(Vec3::Constant(half_size_m), 1), true, {}}},
                {"other", {make_box(Vec3::Constant(half_size_m), 1), true, {}}}},
        m_poses{{Mat3::Identity(), Vec3(3, 2, 1)}, {Mat3::Identity(), Vec3(-90, 0, 0)}} {
    // The first bone lies on its side, so that world and rest frame differ.
    m_poses[0].rotation = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX()).toRotationMatrix();
    m_up = m_poses[0].apply_to_direction(Vec3::UnitZ());
  }

  /// A node at this height over the top face, negative inside; its number.
  int node_at(double height_m) {
    m_positions.push_back(m_poses[0].apply(Vec3(0.1, 0.05, half_size_m + height_m)));
    return static_cast<int>(m_positions.size()) - 1;
  }
  void answer(int node, double depth_m, const Vec3& normal, int bone = 0) {
    m_contacts.push_back({node, bone, depth_m, normal});
  }
  AnswerErrors errors(bool depths_known = true) {
    Referee referee(m_bones, static_cast<int>(m_positions.size()));
    std::vector<int> nodes(m_positions.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] = static_cast<int>(i);
    std::vector<Contact> truth;
    referee.judge(m_poses, m_positions, nodes, truth);
    AnswerErrors found;
    measure_answer(referee, {m_poses, m_positions, m_contacts, depths_known}, truth, band_m, found);
    return found;
  }

  std::vector<Bone> m_bones;
  std::vector<RigidMotion> m_poses;
  Vec3 m_up;
  std::vector<Vec3> m_positions;
  std::vector<Contact> m_contacts;
};

TEST_F(AnswerError, ATrueContactErrsByItsDepthAndNormal) {
  const Vec3 tilted = std::cos(0.1) * m_up + std::sin(0.1) * Vec3::UnitX();
  answer(node_at(-0.004), 0.005, tilted);
  answer(node_at(-0.002), 0.0005, m_up);
  const AnswerErrors found = errors();
  EXPECT_EQ(found.contacts, 2);
  EXPECT_EQ(found.true_contacts, 2);
  EXPECT_EQ(found.missed_contacts, 0);
  EXPECT_EQ(found.false_contacts, 0);
  ASSERT_EQ(found.depth_errors_m.size(), 2U);
  EXPECT_NEAR(found.depth_errors_m[0], 0.001, 1e-15);
  EXPECT_NEAR(found.depth_errors_m[1], 0.0015, 1e-15);
  ASSERT_EQ(found.normal_errors_deg.size(), 2U);
  EXPECT_NEAR(found.normal_errors_deg[0], 0.1 * 180 / std::numbers::pi, 1e-10);
  EXPECT_NEAR(found.normal_errors_deg[1], 0, 1e-10);
}

TEST_F(AnswerError, AMissedContactIsCountedAndHasNoDepthError) {
  node_at(-0.004);
  answer(node_at(-0.001), 0.001, m_up);
  node_at(-0.003);
  node_at(0.002);
  const AnswerErrors found = errors();
  EXPECT_EQ(found.contacts, 1);
  EXPECT_EQ(found.true_contacts, 3);
  EXPECT_EQ(found.missed_contacts, 2);
  EXPECT_EQ(found.false_contacts, 0);
  EXPECT_NEAR(found.max_missed_depth_m, 0.004, 1e-15);
  ASSERT_EQ(found.depth_errors_m.size(), 1U);
  EXPECT_NEAR(found.depth_errors_m[0], 0, 1e-15);
  EXPECT_EQ(found.normal_errors_deg.size(), 1U);
}

TEST_F(AnswerError, AFalseContactIsCountedAndHasNoDepthError) {
  answer(node_at(0.003), 0.001, -m_up);
  answer(node_at(0.002), 0, Vec3::Zero());
  const AnswerErrors found = errors();
  EXPECT_EQ(found.true_contacts, 0);
  EXPECT_EQ(found.false_contacts, 2);
  EXPECT_NEAR(found.max_false_distance_m, 0.003, 1e-15);
  EXPECT_TRUE(found.depth_errors_m.empty());
  EXPECT_TRUE(found.normal_errors_deg.empty());
}

TEST_F(AnswerError, WithoutDepthsThereIsNoDepthError) {
  answer(node_at(-0.004), 0, Vec3::Zero());
  answer(node_at(0.003), 0, Vec3::Zero());
  node_at(-0.002);
  const AnswerErrors found = errors(false);
  EXPECT_EQ(found.true_contacts, 2);
  EXPECT_EQ(found.missed_contacts, 1);
  EXPECT_EQ(found.false_contacts, 1);
  EXPECT_TRUE(found.depth_errors_m.empty());
  EXPECT_TRUE(found.normal_errors_deg.empty());
}

TEST_F(AnswerError, BeyondTheBandContactsAreCountedButNotMeasured) {
  answer(node_at(-0.02), 0.01, m_up);
  answer(node_at(0.03), 0.01, m_up);
  node_at(-0.04);
  const AnswerErrors found = errors();
  EXPECT_EQ(found.contacts, 2);
  EXPECT_EQ(found.missed_contacts, 1);
  EXPECT_EQ(found.false_contacts, 1);
  EXPECT_TRUE(found.depth_errors_m.empty());
  EXPECT_TRUE(found.normal_errors_deg.empty());
  EXPECT_NEAR(found.max_missed_depth_m, 0.04, 1e-15);
  EXPECT_NEAR(found.max_false_distance_m, 0.03, 1e-15);
}

TEST_F(AnswerError, ContactsWithTwoBonesAreApart) {
  m_poses[1] = m_poses[0];
  m_poses[1].translation_m -= 0.002 * m_up;
  answer(node_at(-0.003), 0.003, m_up, 0);
  answer(node_at(-0.001), 0.001, m_up, 0);
  answer(0, 0.001, m_up, 1);
  answer(1, 0.001, m_up, 1);
  const AnswerErrors found = errors();
  EXPECT_EQ(found.true_contacts, 3);
  EXPECT_EQ(found.missed_contacts, 0);
  EXPECT_EQ(found.false_contacts, 1);
  ASSERT_EQ(found.depth_errors_m.size(), 3U);
  for (const double error_m : found.depth_errors_m) EXPECT_NEAR(error_m, 0, 1e-15);
}

TEST_F(AnswerError, TheOrderIsByBoneFirst) {
  m_poses[1] = m_poses[0];
  m_poses[1].translation_m -= 0.002 * m_up;
  node_at(-0.003);
  node_at(-0.001);
  answer(node_at(0.002), 0.001, m_up, 0);
  answer(0, 0.001, m_up, 1);
  const AnswerErrors found = errors();
  EXPECT_EQ(found.true_contacts, 3);
  EXPECT_EQ(found.missed_contacts, 2);
  EXPECT_EQ(found.false_contacts, 1);
}

TEST(AnswerErrors, Add) {
  AnswerErrors sum{1, 2, 3, 4, 0.5, 0.6, {1}, {2}};
  sum.add({10, 20, 30, 40, 0.1, 0.9, {3, 4}, {}});
  EXPECT_EQ(sum.contacts, 11);
  EXPECT_EQ(sum.true_contacts, 22);
  EXPECT_EQ(sum.missed_contacts, 33);
  EXPECT_EQ(sum.false_contacts, 44);
  EXPECT_EQ(sum.max_missed_depth_m, 0.5);
  EXPECT_EQ(sum.max_false_distance_m, 0.9);
  EXPECT_EQ(sum.depth_errors_m, (std::vector<double>{1, 3, 4}));
  EXPECT_EQ(sum.normal_errors_deg, (std::vector<double>{2}));
}

TEST(ErrorStatistics, NearestRank) {
  const ErrorStatistics one = error_statistics({7});
  EXPECT_EQ(one.max, 7);
  EXPECT_EQ(one.p99, 7);
  EXPECT_EQ(one.mean, 7);
  std::vector<double> values;
  for (int i = 200; i >= 1; --i) values.push_back(i);
  const ErrorStatistics many = error_statistics(values);
  EXPECT_EQ(many.max, 200);
  EXPECT_EQ(many.p99, 198);
  EXPECT_EQ(many.mean, 100.5);
  values.push_back(1000);
  EXPECT_EQ(error_statistics(values).p99, 199);
}

}  // namespace
}  // namespace musclebench

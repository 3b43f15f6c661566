#include "core/contact/contact_impulses.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

/// Two muscles of two nodes each, three bones; steps of half a second, so that impulses are twice what is moved.
ContactImpulses of_two_muscles() {
  std::vector<Body> muscles(2);
  muscles[0].last_node = muscles[1].first_node = 2;
  muscles[1].last_node = 4;
  ContactImpulses impulses(muscles, 3, std::vector<double>{1, 1, 1, 0});
  impulses.set_time_step(0.5);
  return impulses;
}

TEST(ContactImpulses, OfANodeBetweenBonesAreThePushesThatFitIt) {
  ContactImpulses impulses = of_two_muscles();
  const Vec3 slanted = Vec3(1, 0, 1).normalized();
  const std::vector<Contact> contacts = {{0, 0, 1, Vec3::UnitZ()}, {0, 2, 1, slanted}};
  impulses.add_to_bones(0, 3 * Vec3::UnitZ() + 2 * slanted, contacts);
  EXPECT_LT((impulses.push_at(0, 0) - 6 * Vec3::UnitZ()).norm(), 1e-9);
  EXPECT_LT((impulses.push_at(2, 0) - 4 * slanted).norm(), 1e-9);
  EXPECT_EQ(impulses.push_at(1, 0), Vec3::Zero());
}

TEST(ContactImpulses, ThatNormalsDoNotExplainAreFrictionSharedByThePushes) {
  ContactImpulses impulses = of_two_muscles();
  const std::vector<Contact> contacts = {{0, 0, 1, Vec3::UnitZ()}, {0, 1, 1, Vec3::UnitX()}};
  impulses.add_to_bones(0, Vec3(1, 4, 3), contacts);
  EXPECT_LT((impulses.push_at(0, 0) - Vec3(0, 0, 6)).norm(), 1e-9);
  EXPECT_LT((impulses.at(0, 0) - Vec3(0, 6, 6)).norm(), 1e-9);
  EXPECT_LT((impulses.at(1, 0) - Vec3(2, 2, 0)).norm(), 1e-9);
  EXPECT_LT((impulses.known(0) - Vec3(2, 8, 6)).norm(), 1e-9);
}

/// A bone only pushes.
TEST(ContactImpulses, AreNeverPulls) {
  ContactImpulses impulses = of_two_muscles();
  impulses.add_to_bones(1, Vec3(0, 0, -1), std::vector<Contact>{{1, 0, 1, Vec3::UnitZ()}});
  EXPECT_EQ(impulses.push_at(0, 1), Vec3::Zero());
  EXPECT_EQ(impulses.at(0, 1), Vec3(0, 0, -2));
}

TEST(ContactImpulses, BetweenMusclesAreOfTheOtherSide) {
  const ContactImpulses impulses = of_two_muscles();
  const std::array<int, 4> nodes = {0, 2, 3, 1};
  const std::array<double, 4> weights = {1, -0.5, -0.5, 0};
  EXPECT_EQ(impulses.other_side(-1, nodes, weights, 0), impulses.of_muscle(1));
  EXPECT_EQ(impulses.other_side(-1, nodes, weights, 1), impulses.of_muscle(0));
  EXPECT_EQ(impulses.other_side(2, nodes, weights, 0), 2U);
  EXPECT_EQ(impulses.other_side(-1, {0, 0, 0, 0}, {1, 0, 0, 0}, 0), impulses.unknown());
}

/// Its bone bears them.
TEST(ContactImpulses, OfAnAttachedNodeAreToldToo) {
  ContactImpulses impulses = of_two_muscles();
  impulses.add(3, 0, Vec3::UnitX(), Vec3::UnitX());
  EXPECT_EQ(impulses.at(0, 3), Vec3(2, 0, 0));
  impulses.add(2, 0, Vec3::UnitX(), Vec3::UnitX());
  EXPECT_EQ(impulses.at(0, 2), Vec3(2, 0, 0));
  impulses.clear();
  EXPECT_EQ(impulses.at(0, 2), Vec3::Zero());
}

}  // namespace
}  // namespace musclebench

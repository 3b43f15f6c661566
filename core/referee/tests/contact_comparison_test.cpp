#include "core/referee/contact_comparison.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

Contact contact(int bone, int node, double depth_m = 1e-3) { return {node, bone, depth_m, Vec3::UnitX()}; }

TEST(CompareContacts, EqualListsDoNotDiffer) {
  const std::vector<Contact> list{contact(0, 3), contact(0, 7), contact(1, 3)};
  const ContactDifference difference = compare_contacts(list, list);
  EXPECT_EQ(difference.missed, 0);
  EXPECT_EQ(difference.false_contacts, 0);
}

TEST(CompareContacts, EmptyLists) {
  const std::vector<Contact> none;
  const std::vector<Contact> two{contact(0, 1), contact(2, 0)};
  EXPECT_EQ(compare_contacts(none, none).missed, 0);
  EXPECT_EQ(compare_contacts(none, none).false_contacts, 0);
  EXPECT_EQ(compare_contacts(none, two).missed, 2);
  EXPECT_EQ(compare_contacts(none, two).false_contacts, 0);
  EXPECT_EQ(compare_contacts(two, none).missed, 0);
  EXPECT_EQ(compare_contacts(two, none).false_contacts, 2);
}

TEST(CompareContacts, CountsBothKindsAcrossBones) {
  const std::vector<Contact> answered{contact(0, 1), contact(0, 5), contact(1, 2), contact(1, 9)};
  const std::vector<Contact> truth{contact(0, 5), contact(0, 6), contact(1, 1), contact(1, 2), contact(2, 0)};
  const ContactDifference difference = compare_contacts(answered, truth);
  EXPECT_EQ(difference.missed, 3);
  EXPECT_EQ(difference.false_contacts, 2);
}

TEST(CompareContacts, TheSameNodeInAnotherBoneIsAnotherContact) {
  const std::vector<Contact> answered{contact(0, 4)};
  const std::vector<Contact> truth{contact(1, 4)};
  EXPECT_EQ(compare_contacts(answered, truth).missed, 1);
  EXPECT_EQ(compare_contacts(answered, truth).false_contacts, 1);
}

TEST(CompareContacts, DepthAndNormalDoNotCount) {
  const std::vector<Contact> answered{{4, 0, 0.0, Vec3::Zero()}};
  const std::vector<Contact> truth{contact(0, 4, 5e-3)};
  EXPECT_EQ(compare_contacts(answered, truth).missed, 0);
  EXPECT_EQ(compare_contacts(answered, truth).false_contacts, 0);
}

TEST(DepthStatistics, NothingInside) {
  const DepthStatistics statistics = depth_statistics({});
  EXPECT_EQ(statistics.nodes_inside, 0);
  EXPECT_EQ(statistics.max_depth_m, 0);
  EXPECT_EQ(statistics.p99_depth_m, 0);
  EXPECT_EQ(statistics.mean_depth_m, 0);
}

TEST(DepthStatistics, OneNode) {
  const std::vector<Contact> truth{contact(0, 4, 2e-3)};
  const DepthStatistics statistics = depth_statistics(truth);
  EXPECT_EQ(statistics.nodes_inside, 1);
  EXPECT_EQ(statistics.max_depth_m, 2e-3);
  EXPECT_EQ(statistics.p99_depth_m, 2e-3);
  EXPECT_EQ(statistics.mean_depth_m, 2e-3);
}

TEST(DepthStatistics, ANodeInSeveralBonesCountsWithItsLargestDepth) {
  const std::vector<Contact> truth{contact(0, 4, 4e-3), contact(0, 5, 1e-3), contact(1, 4, 2e-3), contact(2, 5, 2e-3)};
  const DepthStatistics statistics = depth_statistics(truth);
  EXPECT_EQ(statistics.nodes_inside, 2);
  EXPECT_EQ(statistics.max_depth_m, 4e-3);
  EXPECT_DOUBLE_EQ(statistics.mean_depth_m, 3e-3);
}

/// Depths 1, 2, ... count, the deepest first.
std::vector<Contact> staircase(int count) {
  std::vector<Contact> contacts;
  for (int node = 0; node < count; ++node) contacts.push_back(contact(0, node, count - node));
  return contacts;
}

TEST(DepthStatistics, PercentileIsTheNearestRank) {
  EXPECT_EQ(depth_statistics(staircase(99)).p99_depth_m, 99);
  EXPECT_EQ(depth_statistics(staircase(100)).p99_depth_m, 99);
  EXPECT_EQ(depth_statistics(staircase(101)).p99_depth_m, 100);
  EXPECT_EQ(depth_statistics(staircase(200)).p99_depth_m, 198);
  EXPECT_EQ(depth_statistics(staircase(200)).max_depth_m, 200);
}

TEST(DepthStatistics, EqualDepths) {
  std::vector<Contact> truth;
  for (int node = 0; node < 7; ++node) truth.push_back(contact(0, node, 3e-3));
  const DepthStatistics statistics = depth_statistics(truth);
  EXPECT_EQ(statistics.nodes_inside, 7);
  EXPECT_EQ(statistics.max_depth_m, 3e-3);
  EXPECT_EQ(statistics.p99_depth_m, 3e-3);
  EXPECT_DOUBLE_EQ(statistics.mean_depth_m, 3e-3);
}

}  // namespace
}  // namespace musclebench

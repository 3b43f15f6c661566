// How contacts between muscles are corrected, by hand.
#include "core/contact/muscle_contact_rows.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

/// Nodes 0 to 2 are a triangle in the plane z = 0 that looks up; node 3 and on are of the other muscle.
const std::vector<Triangle> triangles = {{0, 1, 2}};

std::vector<Vec3> corners() { return {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}; }

MuscleContact contact(int node, const Vec3& weights, double depth_m) {
  return {node, 0, 0, weights, depth_m, Vec3::UnitZ()};
}

/// Of the plane through the corners at the contact's weights.
double gap_m(const MuscleContact& contact, const std::vector<Vec3>& positions) {
  const Vec3 on_triangle =
      contact.weights.x() * positions[0] + contact.weights.y() * positions[1] + contact.weights.z() * positions[2];
  return contact.normal.dot(positions[static_cast<std::size_t>(contact.node)] - on_triangle);
}

/// What a stage does with the contacts of a substep.
class RowResponse {
 public:
  RowResponse(std::span<const Triangle> of, std::vector<double> inverse_masses, PairSteps steps, double friction = 0)
      : m_triangles(of), m_steps(std::move(steps)), m_solver(std::move(inverse_masses), friction) {}

  void resolve(std::span<const MuscleContact> contacts, std::span<Vec3> start, std::span<Vec3> predicted) {
    rows_of(contacts, m_triangles, m_steps, m_rows);
    m_solver.solve(m_rows, start, predicted);
  }
  [[nodiscard]] std::span<const int> moved_nodes() const { return m_solver.moved_nodes(); }

 private:
  std::span<const Triangle> m_triangles;
  PairSteps m_steps;
  ContactRowSolver m_solver;
  std::vector<ContactRow> m_rows;
};

TEST(MuscleContactRows, TakesOneNodeOutByInverseMass) {
  for (const double mass_ratio : {1.0, 3.0}) {
    RowResponse response(triangles, {2, 2, 2, 2 / mass_ratio}, 1);
    std::vector<Vec3> predicted = corners();
    predicted.emplace_back(0.2, 0.3, -0.1);
    std::vector<Vec3> start = predicted;
    start[3].z() = 0.5;  // it was free where the substep began
    const std::vector<Vec3> before = start;
    const MuscleContact one = contact(3, Vec3(0.5, 0.2, 0.3), 0.1);
    const std::vector<Vec3> old = predicted;
    response.resolve({&one, 1}, start, predicted);
    EXPECT_NEAR(gap_m(one, predicted), 0, 1e-15);
    EXPECT_EQ(start, before);
    Vec3 momentum = mass_ratio * (predicted[3] - old[3]);
    for (std::size_t i = 0; i < 3; ++i) momentum += predicted[i] - old[i];
    EXPECT_LT(momentum.norm(), 1e-16);
    // The corners move by their weights.
    EXPECT_NEAR((predicted[0].z() - old[0].z()) / (predicted[1].z() - old[1].z()), 0.5 / 0.2, 1e-12);
    EXPECT_EQ(std::vector<int>(response.moved_nodes().begin(), response.moved_nodes().end()),
              (std::vector<int>{0, 1, 2, 3}));
  }
}

TEST(MuscleContactRows, WhatBoneHoldsStaysAndTheOtherSideGivesWay) {
  const MuscleContact one = contact(3, Vec3(0.5, 0.2, 0.3), 0.1);
  for (const bool node_is_bound : {false, true}) {
    RowResponse response(triangles, node_is_bound ? std::vector<double>{1, 1, 1, 0} : std::vector<double>{0, 0, 0, 1},
                         1);
    std::vector<Vec3> predicted = corners();
    predicted.emplace_back(0.2, 0.3, -0.1);
    const std::vector<Vec3> old = predicted;
    std::vector<Vec3> start(4, Vec3(0, 0, 1));
    response.resolve({&one, 1}, start, predicted);
    EXPECT_NEAR(gap_m(one, predicted), 0, 1e-15);
    for (std::size_t i = node_is_bound ? 3 : 0; i < (node_is_bound ? 4U : 3U); ++i) EXPECT_EQ(predicted[i], old[i]);
  }
  // Both are held: nothing moves, and nothing is divided by 0.
  RowResponse response(triangles, {0, 0, 0, 0}, 3);
  std::vector<Vec3> predicted = corners();
  predicted.emplace_back(0.2, 0.3, -0.1);
  const std::vector<Vec3> old = predicted;
  std::vector<Vec3> start = predicted;
  response.resolve({&one, 1}, start, predicted);
  EXPECT_EQ(predicted, old);
}

TEST(MuscleContactRows, WhatWasInsideAtTheStartGetsNoVelocity) {
  RowResponse response(triangles, {1, 1, 1, 1}, 1);
  std::vector<Vec3> predicted = corners();
  predicted.emplace_back(0.2, 0.3, -0.1);
  std::vector<Vec3> start = corners();
  start.emplace_back(0.2, 0.3, -0.04);  // 40 % of the depth were there before the substep
  const std::vector<Vec3> old_predicted = predicted;
  const std::vector<Vec3> old_start = start;
  const MuscleContact one = contact(3, Vec3(0.5, 0.2, 0.3), 0.1);
  response.resolve({&one, 1}, start, predicted);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(start[i].z() - old_start[i].z(), 0.4 * (predicted[i].z() - old_predicted[i].z()), 1e-16);
  }
}

/// Many nodes over one triangle: each corner is asked for by all of them.
class ManyContacts : public testing::Test {
 protected:
  static constexpr int count = 40;

  ManyContacts() : m_inverse_masses(3 + count, 1) {
    std::mt19937 generator(4);
    std::uniform_real_distribution<double> share(0, 1);
    for (int i = 0; i < count; ++i) {
      double v = share(generator);
      double w = share(generator);
      if (v + w > 1) {
        v = 1 - v;
        w = 1 - w;
      }
      m_contacts.push_back(contact(3 + i, Vec3(1 - v - w, v, w), 0.01));
    }
  }

  [[nodiscard]] std::vector<Vec3> positions(double (*depth_m)(int i)) const {
    std::vector<Vec3> made = corners();
    for (int i = 0; i < count; ++i) {
      const Vec3& weights = m_contacts[static_cast<std::size_t>(i)].weights;
      made.emplace_back(weights.y(), weights.z(), -depth_m(i));
    }
    return made;
  }

  std::vector<double> m_inverse_masses;
  std::vector<MuscleContact> m_contacts;
};

TEST_F(ManyContacts, OfOneDepthAreSolvedAtOnceAndNeverOvershoot) {
  RowResponse response(triangles, m_inverse_masses, 1);
  std::vector<Vec3> predicted = positions([](int) { return 0.01; });
  std::vector<Vec3> start = predicted;
  response.resolve(m_contacts, start, predicted);
  double least_m = 1;
  double largest_m = -1;
  for (const MuscleContact& one : m_contacts) {
    least_m = std::min(least_m, gap_m(one, predicted));
    largest_m = std::max(largest_m, gap_m(one, predicted));
  }
  EXPECT_LT(largest_m, 0.002) << "moved beyond free";
  EXPECT_GT(least_m, -0.002) << "hardly moved";
}

TEST_F(ManyContacts, OfAnyDepthConvergeKeepMomentumAndHaveNoOrder) {
  const auto depth_m = [](int i) { return i % 3 == 0 ? 0.012 : 0.001 * (i % 5); };
  std::vector<Vec3> predicted = positions(depth_m);
  std::vector<Vec3> start = predicted;
  Vec3 before = Vec3::Zero();
  for (const Vec3& position : predicted) before += position;
  std::vector<Vec3> shuffled_predicted = predicted;
  std::vector<Vec3> shuffled_start = predicted;

  RowResponse(triangles, m_inverse_masses, 200).resolve(m_contacts, start, predicted);
  Vec3 after = Vec3::Zero();
  for (const Vec3& position : predicted) after += position;
  EXPECT_LT((after - before).norm(), 1e-14);
  for (const MuscleContact& one : m_contacts) EXPECT_GT(gap_m(one, predicted), -1e-6);

  std::shuffle(m_contacts.begin(), m_contacts.end(), std::mt19937(9));
  RowResponse(triangles, m_inverse_masses, 200).resolve(m_contacts, shuffled_start, shuffled_predicted);
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    EXPECT_LT((predicted[i] - shuffled_predicted[i]).norm(), 1e-14);
  }
}

/// A node that comes down on a triangle and slides along it.
struct Sliding {
  std::vector<Vec3> start = corners();
  std::vector<Vec3> predicted = corners();
  MuscleContact one = contact(3, Vec3(0.5, 0.2, 0.3), 0.01);

  explicit Sliding(double slide_m) {
    start.emplace_back(0.2, 0.3, 0.02);
    predicted.emplace_back(0.2 + slide_m, 0.3, -0.01);
  }

  /// What is left of the slide between the node and its point of the triangle, m.
  double slide_left_m(double friction, const std::vector<double>& inverse_masses) {
    RowResponse response(triangles, inverse_masses, 5, friction);
    response.resolve({&one, 1}, start, predicted);
    const auto apart = [&](const std::vector<Vec3>& at) {
      return Vec3(at[3] - 0.5 * at[0] - 0.2 * at[1] - 0.3 * at[2]);
    };
    return (apart(predicted) - apart(start)).x();
  }
};

/// The push is 10 mm: friction undoes the coefficient times that, and a smaller slide whole.
TEST(MuscleContactRows, FrictionUndoesASlideByThePush) {
  for (const std::vector<double>& inverse_masses : {std::vector<double>{0, 0, 0, 1}, std::vector<double>{1, 2, 3, 4}}) {
    EXPECT_NEAR(Sliding(0.05).slide_left_m(0, inverse_masses), 0.05, 1e-15);
    EXPECT_NEAR(Sliding(0.05).slide_left_m(0.5, inverse_masses), 0.045, 1e-15);
    EXPECT_NEAR(Sliding(0.004).slide_left_m(0.5, inverse_masses), 0, 1e-15);
  }
}

TEST(MuscleContactRows, FrictionKeepsMomentum) {
  const std::vector<double> inverse_masses = {1, 2, 3, 4};
  Sliding sliding(0.05);
  const std::vector<Vec3> old = sliding.predicted;
  (void)sliding.slide_left_m(1, inverse_masses);
  Vec3 momentum = Vec3::Zero();
  for (std::size_t i = 0; i < 4; ++i) momentum += (sliding.predicted[i] - old[i]) / inverse_masses[i];
  EXPECT_LT(momentum.norm(), 1e-16);
  EXPECT_LT(sliding.predicted[3].x(), old[3].x());
  EXPECT_GT(sliding.predicted[0].x(), old[0].x());
}

/// What overlapped when the substep began is laid apart without force, and rubs against nothing.
TEST(MuscleContactRows, FrictionIsNotOfAnOverlapFromBefore) {
  Sliding sliding(0.05);
  sliding.start[3].z() = -0.01;
  EXPECT_NEAR(sliding.slide_left_m(0.5, {0, 0, 0, 1}), 0.05, 1e-15);
}

/// A response is kept over a run: nothing of one substep is left in the next.
TEST(MuscleContactRows, ASecondResolutionIsThatOfANewResponse) {
  const MuscleContact one = contact(3, Vec3(0.5, 0.2, 0.3), 0.1);
  const auto resolved_by = [&](RowResponse& response) {
    std::vector<Vec3> predicted = corners();
    predicted.emplace_back(0.2, 0.3, -0.1);
    std::vector<Vec3> start = predicted;
    response.resolve({&one, 1}, start, predicted);
    return predicted;
  };
  RowResponse response(triangles, {1, 1, 1, 1}, 1);
  const std::vector<Vec3> first = resolved_by(response);
  EXPECT_EQ(resolved_by(response), first);
}

/// Two muscles beside a first one, apart from each other: a pair of one step stays where one step brings it.
TEST(MuscleContactRows, APairHasStepsOfItsOwn) {
  const std::vector<Triangle> two = {{0, 1, 2}, {3, 4, 5}};
  std::vector<Vec3> rest = corners();
  for (const Vec3& corner : corners()) rest.push_back(corner + Vec3(10, 0, 0));
  // A node near a corner and one near the middle of each triangle: a step leaves some of their depth.
  const std::vector<Vec3> weights = {Vec3(0.9, 0.05, 0.05), Vec3(1, 1, 1) / 3};
  std::vector<MuscleContact> contacts;
  for (const double x : {0.0, 10.0}) {
    for (const Vec3& weight : weights) {
      MuscleContact made =
          contact(static_cast<int>(rest.size()), weight, 0.01 * static_cast<double>(1 + contacts.size() % 2));
      made.muscle = x == 0 ? 0 : 1;
      made.triangle = made.muscle;
      contacts.push_back(made);
      rest.emplace_back(x + weight.y(), weight.z(), -made.depth_m);
    }
  }
  const std::vector<Body> bodies = {{"a", 0, 3, 0, 1}, {"b", 3, 6, 1, 2}, {"c", 6, 10, 2, 2}};
  const auto resolved = [&](PairSteps steps) {
    std::vector<Vec3> predicted = rest;
    std::vector<Vec3> start = rest;
    RowResponse(two, std::vector<double>(rest.size(), 1.0), std::move(steps)).resolve(contacts, start, predicted);
    return predicted;
  };
  const std::vector<Vec3> once = resolved(1);
  const std::vector<Vec3> often = resolved(5);
  const std::vector<Vec3> mixed = resolved({bodies, {{0, 2}, {1, 2}}, {1, 5}});
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const bool is_of_first = i < 3 || i == 6 || i == 7;
    EXPECT_EQ(mixed[i], is_of_first ? once[i] : often[i]) << i;
  }
  EXPECT_NE(once, often);
}

}  // namespace
}  // namespace musclebench

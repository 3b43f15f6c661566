#include "core/contact/contact_rows.hpp"

#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

double gap_m(const ContactRow& row, const std::vector<Vec3>& at) {
  double sum_m = -row.offset_m;
  for (std::size_t k = 0; k < 4; ++k)
    sum_m += row.weights[k] * row.normal.dot(at[static_cast<std::size_t>(row.nodes[k])]);
  return sum_m;
}

/// A face of three nodes against a plane of a bone at height 0.
ContactRow face_row() {
  return {.nodes = {0, 1, 2, 0}, .weights = {0.5, 0.3, 0.2, 0}, .normal = Vec3::UnitZ(), .start_normal = Vec3::UnitZ()};
}

TEST(ContactRows, AFaceAgainstAPlaneMovesByWeightAndInverseMass) {
  ContactRowSolver solver({1, 2, 0});
  std::vector<Vec3> at(3, Vec3(0, 0, -0.01));
  std::vector<Vec3> start(3, Vec3(0, 0, 1));
  const ContactRow row = face_row();
  solver.solve({&row, 1}, start, at);
  EXPECT_NEAR(gap_m(row, at), 0, 1e-16);
  EXPECT_EQ(at[2], Vec3(0, 0, -0.01)) << "held by a bone";
  EXPECT_NEAR((at[0].z() + 0.01) / (at[1].z() + 0.01), 0.5 / (2 * 0.3), 1e-12);
  EXPECT_EQ(start[0], Vec3(0, 0, 1)) << "it was free where the substep began";
  EXPECT_EQ(solver.most_corrected(), 1);
}

TEST(ContactRows, APlaneThatMovesKeepsWhatBeganOutsideFromCountingAsInside) {
  ContactRowSolver solver({1, 1, 1});
  std::vector<Vec3> at(3, Vec3(0, 0, 0));
  std::vector<Vec3> start = at;
  ContactRow row = face_row();
  row.offset_m = 0.01;          // the bone has risen by 10 mm
  row.start_offset_m = -0.001;  // where it was, the face was above it
  solver.solve({&row, 1}, start, at);
  EXPECT_NEAR(gap_m(row, at), 0, 1e-16);
  EXPECT_EQ(start[0], Vec3(0, 0, 0));

  row.offset_m = 0.02;
  row.start_offset_m = 0.015;  // half of the new depth, 10 mm, was there before
  at.assign(3, Vec3(0, 0, 0.01));
  start.assign(3, Vec3(0, 0, 0.01));
  solver.solve({&row, 1}, start, at);
  EXPECT_NEAR((start[0].z() - 0.01) / (at[0].z() - 0.01), 0.5, 1e-12);
}

/// 10 mm deep as the run begins: it leaves by 1 mm a step. What comes in later leaves whole.
TEST(ContactRows, WhatOverlapsAsTheRunBeginsIsLaidOutSlowly) {
  ContactRowSolver solver({1, 1, 1, 1, 1, 1});
  std::vector<Vec3> at = {Vec3(0, 0, -0.01), Vec3(0, 0, -0.01), Vec3(0, 0, -0.01),
                          Vec3(0, 0, 1),     Vec3(0, 0, 1),     Vec3(0, 0, 1)};
  std::vector<Vec3> start = at;
  ContactRow other = face_row();
  other.nodes = {3, 4, 5, 0};
  const auto step = [&](double most_m) {
    std::vector<ContactRow> rows = {face_row(), other};
    solver.lay_out_slowly(rows, start, at, most_m);
    solver.solve(rows, start, at);
  };
  for (int i = 1; i <= 10; ++i) {
    step(0.001);
    EXPECT_NEAR(gap_m(face_row(), at), -0.01 + 0.001 * i, 1e-16);
    EXPECT_NEAR((at[0] - start[0]).norm(), 0, 1e-16);
  }
  for (std::size_t node = 3; node < 6; ++node) at[node].z() = start[node].z() = -0.01;
  step(0.001);
  EXPECT_NEAR(gap_m(other, at), 0, 1e-16);
}

TEST(ContactRows, WithoutALimitWhatOverlapsIsCorrectedAtOnce) {
  ContactRowSolver solver({1, 1, 1});
  std::vector<Vec3> at(3, Vec3(0, 0, -0.01));
  std::vector<Vec3> start = at;
  std::vector<ContactRow> rows = {face_row()};
  solver.lay_out_slowly(rows, start, at, std::numeric_limits<double>::infinity());
  solver.solve(rows, start, at);
  EXPECT_NEAR(gap_m(face_row(), at), 0, 1e-16);
}

/// Its contact is a hundredth of the way to the only corner that can move: the whole gap would take 100 times as much.
TEST(ContactRows, AFaceThatBonesHoldAllButACornerIsNotThrown) {
  ContactRowSolver solver({1, 0, 0});
  std::vector<Vec3> at(3, Vec3(0, 0, -0.01));
  std::vector<Vec3> start(3, Vec3::Zero());
  ContactRow row = face_row();
  row.weights = {0.01, 0.5, 0.49, 0};
  solver.solve({&row, 1}, start, at);
  EXPECT_NEAR(at[0].z() + 0.01, 0.02, 1e-15);
}

/// A face that comes down by 10 mm on a bone and slides by 30 mm, while the bone carries its points by 10 mm.
struct SlidingFace {
  std::vector<Vec3> start = std::vector<Vec3>(3, Vec3(0, 0, 0.001));
  std::vector<Vec3> at = std::vector<Vec3>(3, Vec3(0.03, 0, -0.01));
  std::vector<ContactRow> rows = {face_row()};

  double slide_m(double friction_coefficient) {
    for (ContactRow& row : rows) row.carried_m = Vec3(0.01, 0, 0);
    ContactRowSolver({1, 2, 1}, friction_coefficient).solve(rows, start, at);
    EXPECT_NEAR(gap_m(rows[0], at), 0, 1e-15);
    Vec3 moved = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) moved += rows[0].weights[k] * (at[k] - start[k]);
    return moved.x() - 0.01;
  }
};

TEST(ContactRows, FrictionUndoesASlideOnABoneThatMoves) {
  EXPECT_NEAR(SlidingFace().slide_m(0), 0.02, 1e-15);
  EXPECT_NEAR(SlidingFace().slide_m(0.5), 0.015, 1e-15);
  EXPECT_NEAR(SlidingFace().slide_m(3), 0, 1e-15);
}

TEST(ContactRows, FrictionOfRowsAtOnePlaceIsThatOfOne) {
  SlidingFace sliding;
  sliding.rows.assign(4, face_row());
  EXPECT_NEAR(sliding.slide_m(0.5), 0.015, 1e-14);
}

TEST(ContactRows, ARowThatBearsNothingTakesNoFrictionAway) {
  SlidingFace sliding;
  ContactRow beside = face_row();  // a plane 1 mm below the one that bears the face
  beside.offset_m = beside.start_offset_m = -0.011;
  sliding.rows.push_back(beside);
  for (ContactRow& row : sliding.rows) row.steps = 60;
  EXPECT_NEAR(sliding.slide_m(0.5), 0.015, 1e-14);
}

/// Of the whole step, of nodes of 1 kg: the momentum along x over that along z.
double friction_over_load(const std::vector<ContactRow>& rows, const std::vector<double>& inverse_masses) {
  const std::vector<Vec3> before(inverse_masses.size(), Vec3(0.03, 0, -0.01));
  std::vector<Vec3> at = before;
  std::vector<Vec3> start(inverse_masses.size(), Vec3(0, 0, 0.001));
  ContactRowSolver(inverse_masses, 0.5).solve(rows, start, at);
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < at.size(); ++i) sum += at[i] - before[i];
  return -sum.x() / sum.z();
}

/// A row that touches nothing, 1 mm clear of its plane, shares a node with one that bears the whole load.
TEST(ContactRows, FrictionIsThatOfTheLoadWhateverIsNear) {
  ContactRow beside = face_row();
  beside.nodes = {2, 3, 4, 0};
  beside.offset_m = beside.start_offset_m = -0.011;
  EXPECT_NEAR(friction_over_load({face_row(), beside}, std::vector<double>(5, 1)), 0.5, 1e-12);
}

TEST(ContactRows, FrictionIsThatOfTheLoadWhereACornerMustNotBeThrown) {
  for (const double weight : {0.5, 0.2, 0.05}) {
    ContactRow row = face_row();
    row.weights = {weight, 0.5, 0.5 - weight, 0};
    EXPECT_NEAR(friction_over_load({row}, {1, 0, 0}), 0.5, 1e-12) << weight;
  }
}

TEST(ContactRows, ManyRowsOfAFaceThrowItsFreeCornerNoFartherThanOne) {
  ContactRow row = face_row();
  row.weights = {0.01, 0.5, 0.49, 0};
  for (const std::size_t count : {1U, 4U, 10U}) {
    std::vector<Vec3> at(3, Vec3(0, 0, -0.01));
    std::vector<Vec3> start(3, Vec3::Zero());
    ContactRowSolver({1, 0, 0}).solve(std::vector<ContactRow>(count, row), start, at);
    EXPECT_NEAR(at[0].z() + 0.01, 0.02, 1e-15) << count;
  }
}

TEST(ContactRows, RowsEndWithTheirOwnSteps) {
  // Two rows that pull one node apart never end; the first one is done after one step.
  const std::vector<ContactRow> rows = {
      {.nodes = {0, 0, 0, 0}, .weights = {1, 0, 0, 0}, .normal = Vec3::UnitZ(), .offset_m = 1, .steps = 1},
      {.nodes = {0, 0, 0, 0}, .weights = {1, 0, 0, 0}, .normal = -Vec3::UnitZ(), .offset_m = 1, .steps = 40}};
  ContactRowSolver solver({1});
  std::vector<Vec3> at(1, Vec3::Zero());
  std::vector<Vec3> start(1, Vec3(0, 0, 5));
  solver.solve(rows, start, at);
  EXPECT_NEAR(at[0].z(), -1, 1e-6);
}

TEST(ContactRows, TheOrderOfRowsMeansNothing) {
  std::vector<ContactRow> rows;
  for (int i = 0; i < 4; ++i) {
    rows.push_back({.nodes = {i, i + 1, i + 2, 0},
                    .weights = {0.2, 0.5, 0.3, 0},
                    .normal = Vec3(0.1 * i, 0.2, 1).normalized(),
                    .offset_m = 0.01 * (i + 1),
                    .steps = 5});
  }
  std::vector<Vec3> one(6, Vec3::Zero());
  std::vector<Vec3> other = one;
  std::vector<Vec3> start(6, Vec3(0, 0, 1));
  ContactRowSolver(std::vector<double>(6, 1)).solve(rows, start, one);
  std::swap(rows[0], rows[3]);
  std::swap(rows[1], rows[2]);
  ContactRowSolver(std::vector<double>(6, 1)).solve(rows, start, other);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_LT((one[i] - other[i]).norm(), 1e-17);
}

TEST(ContactRows, NothingIsDividedByNothing) {
  ContactRowSolver solver({0, 0, 0});
  std::vector<Vec3> at(3, Vec3(0, 0, -1));
  std::vector<Vec3> start = at;
  const ContactRow row = face_row();
  solver.solve({&row, 1}, start, at);
  EXPECT_EQ(at[0], Vec3(0, 0, -1));
  solver.solve({}, start, at);
  EXPECT_TRUE(solver.moved_nodes().empty());
}

}  // namespace
}  // namespace musclebench

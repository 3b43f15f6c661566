#include "core/contact/response.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/contact/tests/shape_backend.hpp"

namespace musclebench {
namespace {

using Nodes = std::vector<int>;

/// One collision step as the loop does it: update, detection of all nodes, response.
struct Step {
  std::vector<Vec3> start;      ///< x
  std::vector<Vec3> predicted;  ///< p
  std::vector<RigidMotion> previous;
  std::vector<RigidMotion> now;

  std::vector<Vec3> respond(Response response, ShapeBackend& backend, std::size_t bones) {
    previous.resize(bones);
    now.resize(bones);
    Nodes nodes(predicted.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      nodes[i] = static_cast<int>(i);
    }
    std::vector<Contact> contacts;
    backend.update(now, predicted);
    backend.detect(predicted, nodes, contacts);
    backend.queried.clear();
    backend.asked_at.clear();
    std::vector<Vec3> corrected = predicted;
    response.reserve(predicted.size(), bones);
    response.resolve(backend, {start, previous, now}, contacts, corrected);
    return corrected;
  }
};

std::vector<Vec3> project(ShapeBackend& backend, std::size_t bones, std::vector<Vec3> predicted) {
  Step step;
  step.start = predicted;
  step.predicted = std::move(predicted);
  return step.respond(ResponseKind::project, backend, bones);
}

std::vector<Vec3> backtrack(ShapeBackend& backend, std::size_t bones, std::vector<Vec3> start,
                            std::vector<Vec3> predicted) {
  Step step;
  step.start = std::move(start);
  step.predicted = std::move(predicted);
  return step.respond(ResponseKind::backtrack, backend, bones);
}

Vec3 at_angle(double degrees) {
  const double angle_rad = degrees * M_PI / 180;
  return {std::cos(angle_rad), 0, std::sin(angle_rad)};
}

TEST(ProjectResponse, MovesByTheDepthAlongTheNormalOfTheBoneWhereItStands) {
  ShapeBackend backend({half_space(Vec3::UnitZ())});
  Step step;
  step.start = step.predicted = {Vec3(0.5, 2, -0.25), Vec3(-0.25, 2, 0.5)};
  step.now = {RigidMotion::about_axis(Vec3::UnitY(), Vec3::Zero(), M_PI / 2)};  // x < 0
  const auto corrected = step.respond(ResponseKind::project, backend, 1);
  EXPECT_EQ(corrected[0], Vec3(0.5, 2, -0.25));
  EXPECT_LT((corrected[1] - Vec3(0, 2, 0.5)).norm(), 1e-15);
}

TEST(ProjectResponse, WithoutAContactNothingIsAskedOrMoved) {
  ShapeBackend backend({half_space(Vec3::UnitZ())});
  EXPECT_EQ(project(backend, 1, {Vec3(0.5, 0, 0.25)})[0], Vec3(0.5, 0, 0.25));
  EXPECT_TRUE(backend.queried.empty());
}

/// A backend that tells half of the depth leaves a half, a quarter, an eighth of it.
TEST(ProjectResponse, TakesThreeStepsAndNoMore) {
  Shape floor = half_space(Vec3::UnitZ());
  floor.reported_depth = 0.5;
  ShapeBackend backend({floor});
  EXPECT_EQ(project(backend, 1, {Vec3(0, 0, -1)})[0], Vec3(0, 0, -0.125));
  EXPECT_EQ(backend.queried.size(), 2U);  // the first step is the loop's own detection
}

TEST(ProjectResponse, LaterStepsKeepTheMargin) {
  Shape floor = half_space(Vec3::UnitZ());
  floor.reported_depth = 0.5;
  ShapeBackend backend({floor});
  Response response(ResponseKind::project);
  response.set_margin(0.1);
  Step step;
  step.start = step.predicted = {Vec3(0, 0, -1)};
  const Vec3 corrected = step.respond(std::move(response), backend, 1)[0];
  // Of the first contact the caller adds it; then 0.25 + 0.1, and 0.075 + 0.1.
  EXPECT_NEAR(corrected.z(), 0.025, 1e-15);
}

TEST(ProjectResponse, StopsAsSoonAsNothingIsInside) {
  ShapeBackend backend({half_space(Vec3::UnitZ())});
  EXPECT_EQ(project(backend, 1, {Vec3(0, 0, -1)})[0], Vec3(0, 0, 0));
  EXPECT_EQ(backend.queried.size(), 1U);
}

/// Two floors in a groove of 60 degrees: out of the first into the second, out of that into the first again. Each push
/// takes the node to the other floor and is half as deep as the one before: 1, 1/2, 1/4.
TEST(ProjectResponse, LaterStepsLeaveTheBonesThatEarlierOnesPushedInto) {
  const Vec3 first = at_angle(90);
  const Vec3 second = at_angle(210);
  ShapeBackend backend({half_space(first), half_space(second)});
  // On the second floor, 1 deep in the first.
  const Vec3 along_second(-std::sin(M_PI * 210 / 180), 0, std::cos(M_PI * 210 / 180));
  const Vec3 start = along_second / along_second.z() * -1.0;
  ASSERT_NEAR(first.dot(start), -1, 1e-15);
  ASSERT_NEAR(second.dot(start), 0, 1e-15);
  const Vec3 nudged = start + 1e-9 * second;  // free of the second
  Vec3 expected = nudged;
  expected -= first.dot(expected) * first;
  ASSERT_NEAR(second.dot(expected), -0.5, 1e-8);
  expected -= second.dot(expected) * second;
  ASSERT_NEAR(first.dot(expected), -0.25, 1e-8);
  expected -= first.dot(expected) * first;
  EXPECT_LT((project(backend, 2, {nudged})[0] - expected).norm(), 1e-12);
}

TEST(ProjectResponse, LaterStepsAskOnlyTheNodesStillInsideEachOnce) {
  Shape slow = half_space(Vec3::UnitX());
  slow.reported_depth = 0.5;
  ShapeBackend backend({half_space(Vec3::UnitZ()), slow});
  // By bone, then node, the contacts are 1 2 4 and 2 3: node 2 is in both bones, 0 in none; 1 and 4 come free at once.
  const Vec3 in_floor(1, 0, -1);
  const Vec3 in_wall(-1, 0, 1);
  const Vec3 in_both(-1, 0, -1);
  const auto corrected = project(backend, 2, {Vec3(1, 0, 1), in_floor, in_both, in_wall, in_floor});
  EXPECT_EQ(backend.queried, (std::vector<Nodes>{{1, 2, 3, 4}, {2, 3}}));
  EXPECT_EQ(corrected,
            (std::vector<Vec3>{Vec3(1, 0, 1), Vec3(1, 0, 0), Vec3(-0.125, 0, 0), Vec3(-0.125, 0, 1), Vec3(1, 0, 0)}));
}

/// Corrections of one step are added, even where that is too far: two walls at 120 degrees.
TEST(ProjectResponse, AddsTheCorrectionsOfSeveralBones) {
  const Vec3 left = at_angle(60);
  const Vec3 right = at_angle(120);
  ShapeBackend backend({half_space(left), half_space(right), half_space(Vec3::UnitZ(), -0.9)});
  const Vec3 inside(0, 0, -1);
  const double depth_m = std::sin(M_PI / 3);
  const Vec3 expected = inside + depth_m * left + depth_m * right + 0.1 * Vec3::UnitZ();
  EXPECT_LT((project(backend, 3, {inside})[0] - expected).norm(), 1e-15);
}

TEST(ProjectResponse, ABackendOfWholeSurfacesIsAskedOnlyByTheLoop) {
  Shape floor = half_space(Vec3::UnitZ());
  floor.reported_depth = 0.5;
  ShapeBackend backend({floor}, false);
  EXPECT_EQ(project(backend, 1, {Vec3(0, 0, -1)})[0], Vec3(0, 0, -0.5));
  EXPECT_TRUE(backend.queried.empty());
}

TEST(BacktrackResponse, WalksTowardsTheStartInStepsOfTheBone) {
  Shape floor = half_space(Vec3::UnitZ());
  floor.step_m = 0.1;
  ShapeBackend backend({floor});
  // Along a slanted line of length 5: 0.1 of it is 0.08 up. Inside at -0.25, -0.17, -0.09, -0.01; free at 0.07.
  const Vec3 start(3, 0, 3.75);
  const Vec3 predicted(0, 0, -0.25);
  const Vec3 expected = predicted + 0.4 * Vec3(0.6, 0, 0.8);
  EXPECT_LT((backtrack(backend, 1, {start}, {predicted})[0] - expected).norm(), 1e-14);
  EXPECT_EQ(backend.queried.size(), 5U);  // x, and the four positions of the backtracking
}

TEST(BacktrackResponse, TheFirstTrialIsOneStepAway) {
  Shape floor = half_space(Vec3::UnitZ());
  floor.step_m = 0.5;
  ShapeBackend backend({floor});
  EXPECT_EQ(backtrack(backend, 1, {Vec3(0, 0, 1.875)}, {Vec3(0, 0, -0.125)})[0], Vec3(0, 0, 0.375));
}

TEST(BacktrackResponse, NeverPassesTheStart) {
  Shape floor = half_space(Vec3::UnitZ());
  floor.step_m = 0.25;
  ShapeBackend backend({floor});
  const double height_m = std::ldexp(1.0, -20);  // free by less than any step
  const Vec3 just_free(0.5, 0, height_m);
  for (const double depth_m : {0.125, 0.25 + height_m, 0.375}) {
    EXPECT_EQ(backtrack(backend, 1, {just_free}, {Vec3(0.5, 0, -depth_m)})[0], just_free) << depth_m;
  }
}

TEST(BacktrackResponse, EveryNodeWalksAsFarAsItHasTo) {
  Shape round = ball(Vec3::Zero(), 1);
  round.step_m = 0.25;
  ShapeBackend backend({round});
  const std::vector<Vec3> start = {Vec3(2.875, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 4.5), Vec3(0, 0, -1.0625)};
  const std::vector<Vec3> predicted = {Vec3(0.875, 0, 0), Vec3(0, 2, 0), Vec3(0, 0, 0.5), Vec3(0, 0, -0.6875)};
  const auto corrected = backtrack(backend, 1, start, predicted);
  EXPECT_EQ(corrected[0], Vec3(1.125, 0, 0));
  EXPECT_EQ(corrected[1], predicted[1]);   // never inside
  EXPECT_EQ(corrected[2], Vec3(0, 0, 1));  // on the surface is outside
  EXPECT_EQ(corrected[3], start[3]);
  EXPECT_EQ(backend.queried, (std::vector<Nodes>{{0, 2, 3}, {0, 2, 3}, {2}}));
}

/// x was computed with the previous pose: a node that was in the bone then keeps its position in the bone's rest frame.
TEST(BacktrackResponse, ANodeWhoseStartIsInsideFollowsTheBoneFromItsPreviousPose) {
  ShapeBackend backend({half_space(Vec3::UnitZ())});
  Step step;
  step.previous = {RigidMotion::about_axis(Vec3(1, 2, 2) / 3, Vec3(0.1, -0.2, 0.3), 0.4)};
  step.now = {RigidMotion::about_axis(Vec3(2, -1, 2) / 3, Vec3(-0.3, 0.1, 0.2), -0.3) *
              RigidMotion{Mat3::Identity(), Vec3(0.2, 0.01, -0.05)}};
  const Vec3 in_rest_frame(0.2, 0.3, -0.5);
  step.start = {step.previous[0].apply(in_rest_frame)};
  step.predicted = {step.start[0] + Vec3(0.01, 0.02, -0.03)};
  const auto corrected = step.respond(ResponseKind::backtrack, backend, 1);
  EXPECT_LT((corrected[0] - step.now[0].apply(in_rest_frame)).norm(), 1e-15);
  EXPECT_GT((step.now[0].apply(in_rest_frame) - step.start[0]).norm(), 0.01);  // the bone does move
  EXPECT_EQ(backend.queried.size(), 1U);                                       // at x; nothing backtracks
}

/// Whether x is inside is queried at the current bone poses.
TEST(BacktrackResponse, ABoneThatComesOverANodeAtRestCarriesItAlong) {
  Shape floor = half_space(Vec3::UnitZ());
  ShapeBackend backend({floor});
  Step step;
  step.previous = {RigidMotion{Mat3::Identity(), Vec3(0, 0, -1)}};
  step.now = {RigidMotion{}};
  step.start = step.predicted = {Vec3(0.5, 0, -0.25)};
  EXPECT_EQ(step.respond(ResponseKind::backtrack, backend, 1)[0], Vec3(0.5, 0, 0.75));
}

TEST(BacktrackResponse, SomeNodesWalkWhileOthersFollow) {
  Shape floor = half_space(Vec3::UnitZ());
  floor.step_m = 0.25;
  ShapeBackend backend({floor});
  Step step;
  step.previous = {RigidMotion{Mat3::Identity(), Vec3(-1, 0, 0)}};
  step.now = {RigidMotion{}};
  const Vec3 inside(0, 0, -2);
  const Vec3 outside(0, 0, 1.875);
  const Vec3 predicted(0, 0, -0.125);
  step.start = {inside, outside, inside, outside, outside, inside};
  step.predicted = {predicted, predicted, Vec3(0, 0, 1), predicted, Vec3(0, 0, 1), predicted};
  const Vec3 followed(1, 0, -2);
  const Vec3 walked(0, 0, 0.125);
  EXPECT_EQ(step.respond(ResponseKind::backtrack, backend, 1),
            (std::vector<Vec3>{followed, walked, Vec3(0, 0, 1), walked, Vec3(0, 0, 1), followed}));
}

/// The start is in bone 0, the node runs into bone 1: it backtracks out of that, and does not follow bone 1.
TEST(BacktrackResponse, OnlyTheBoneThatTheStartIsInIsFollowed) {
  const Shape left = half_space(Vec3::UnitX(), -1);  // x < -1 is inside
  Shape right = half_space(-Vec3::UnitX(), -1);      // x > 1
  right.step_m = 0.5;
  for (const bool swapped : {false, true}) {
    ShapeBackend backend(swapped ? std::vector<Shape>{right, left} : std::vector<Shape>{left, right});
    Step step;
    step.previous.assign(2, RigidMotion{Mat3::Identity(), Vec3(0, -1, 0)});
    step.now.assign(2, RigidMotion{});
    step.start = {Vec3(-2, 0, 0)};
    step.predicted = {Vec3(1.75, 0, 0)};
    EXPECT_EQ(step.respond(ResponseKind::backtrack, backend, 2)[0], Vec3(0.75, 0, 0)) << swapped;
  }
}

/// Backtracking out of one bone ends where that bone ends, though another still holds the node.
TEST(BacktrackResponse, CorrectionsOfSeveralBonesAreAddedAndTheirOrderDoesNotMatter) {
  Shape floor = half_space(Vec3::UnitZ());
  floor.step_m = 0.25;
  Shape deep = half_space(Vec3::UnitZ(), 0.5);
  deep.step_m = 0.125;
  Shape wall = half_space(Vec3::UnitX());
  wall.step_m = 1;
  const Vec3 start(0, 0, 3.625);
  const Vec3 predicted(0, 0, -0.375);
  const std::vector<std::vector<Shape>> orders = {{floor, deep, wall}, {deep, floor, wall}, {wall, deep, floor}};
  for (std::size_t i = 0; i < orders.size(); ++i) {
    ShapeBackend backend(orders[i]);
    // Out of the floor by two of its steps, out of the deeper one by seven of its own.
    EXPECT_EQ(backtrack(backend, 3, {start}, {predicted})[0], Vec3(0, 0, -0.375 + 0.5 + 0.875)) << i;
  }
}

TEST(BacktrackResponse, FollowingTwoBonesAddsTheirMotions) {
  for (const bool swapped : {false, true}) {
    const Shape wall = half_space(Vec3::UnitX());
    const Shape floor = half_space(Vec3::UnitZ());
    const RigidMotion wall_before{Mat3::Identity(), Vec3(-0.25, 0, 0)};
    const RigidMotion floor_before{Mat3::Identity(), Vec3(0, 0, -0.5)};
    ShapeBackend backend(swapped ? std::vector<Shape>{floor, wall} : std::vector<Shape>{wall, floor});
    Step step;
    step.previous = swapped ? std::vector{floor_before, wall_before} : std::vector{wall_before, floor_before};
    step.now.assign(2, RigidMotion{});
    step.start = {Vec3(-2, 0, -2)};
    step.predicted = {Vec3(-2, 0, -2)};
    EXPECT_EQ(step.respond(ResponseKind::backtrack, backend, 2)[0], Vec3(-1.75, 0, -1.5)) << swapped;
  }
}

TEST(BacktrackResponse, WithoutAContactNothingIsAskedOrMoved) {
  ShapeBackend backend({half_space(Vec3::UnitZ())});
  EXPECT_EQ(backtrack(backend, 1, {Vec3(0, 0, -1)}, {Vec3(0, 0, 1)})[0], Vec3(0, 0, 1));
  EXPECT_TRUE(backend.queried.empty());
}

/// Scratch memory of one call says nothing in the next.
TEST(BacktrackResponse, AResponseCanBeUsedAgain) {
  Shape floor = half_space(Vec3::UnitZ());
  floor.step_m = 0.25;
  ShapeBackend backend({floor});
  Response response(ResponseKind::backtrack);
  const std::vector<RigidMotion> poses(1);
  const auto run = [&](const std::vector<Vec3>& start, std::vector<Vec3> predicted) {
    Nodes nodes(predicted.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      nodes[i] = static_cast<int>(i);
    }
    std::vector<Contact> contacts;
    backend.detect(predicted, nodes, contacts);
    response.resolve(backend, {start, poses, poses}, contacts, predicted);
    return predicted;
  };
  backend.update(poses, {});
  run(std::vector<Vec3>(3, Vec3(0, 0, 1)), std::vector<Vec3>(3, Vec3(0, 0, -0.625)));
  EXPECT_EQ(run({Vec3(0, 0, 1.875), Vec3(0, 0, 2)}, {Vec3(0, 0, -0.125), Vec3(0, 0, 1)}),
            (std::vector<Vec3>{Vec3(0, 0, 0.125), Vec3(0, 0, 1)}));
}

/// A node in both bones gets the sum of what each alone would do to it, in whichever order the bones are.
TEST(ResponsesByBone, EachBoneCorrectsItsOwnWayFromTheSamePosition) {
  const Vec3 start(1, 0, 1);
  const Vec3 predicted(-0.5, 0, -0.25);
  Shape floor = half_space(Vec3::UnitZ());
  floor.step_m = 0.125;
  const Shape wall = half_space(Vec3::UnitX());
  ShapeBackend only_floor({floor});
  const Vec3 backtracked = backtrack(only_floor, 1, {start}, {predicted})[0] - predicted;
  ASSERT_GT(backtracked.z(), 0.25 - 1e-12);
  const Vec3 expected = predicted + backtracked + Vec3(0.5, 0, 0);

  Step step{{start}, {predicted}, {}, {}};
  ShapeBackend backend({floor, wall});
  const BoneResponse back{ResponseKind::backtrack};
  const BoneResponse out{ResponseKind::project};
  EXPECT_LT((step.respond(Response(std::vector{back, out}), backend, 2)[0] - expected).norm(), 1e-15);
  ShapeBackend swapped({wall, floor});
  EXPECT_LT((step.respond(Response(std::vector{out, back}), swapped, 2)[0] - expected).norm(), 1e-15);
}

/// Half of the depth a step: after one, three and five steps a half, an eighth and a 32nd of it is left.
TEST(ResponsesByBone, EachBoneHasItsOwnNumberOfSteps) {
  Shape floor = half_space(Vec3::UnitZ());
  floor.reported_depth = 0.5;
  Shape wall = half_space(Vec3::UnitX());
  wall.reported_depth = 0.5;
  ShapeBackend backend({floor, wall});
  Step step{{Vec3(1, 0, 1)}, {Vec3(-1, 0, -1)}, {}, {}};
  const auto left = [&](int of_floor, int of_wall) {
    return step.respond(Response(std::vector{BoneResponse{ResponseKind::project, of_floor},
                                             BoneResponse{ResponseKind::project, of_wall}}),
                        backend, 2)[0];
  };
  EXPECT_EQ(left(1, 3), Vec3(-0.125, 0, -0.5));
  EXPECT_EQ(left(5, 1), Vec3(-0.5, 0, -1.0 / 32));
}

/// A step that leaves half of the depth, in one step for the nodes of the first muscle and in three for the second.
TEST(ResponsesByBone, EachMuscleHasItsOwn) {
  Shape floor = half_space(Vec3::UnitZ());
  floor.reported_depth = 0.5;
  ShapeBackend backend({floor});
  Step step{{Vec3(0, 0, 1), Vec3(1, 0, 1)}, {Vec3(0, 0, -1), Vec3(1, 0, -1)}, {}, {}};
  const std::vector<Body> muscles{{"first", 0, 1}, {"second", 1, 2}};
  const Response response({BoneResponse{ResponseKind::project, 1}, BoneResponse{ResponseKind::project, 3}}, muscles);
  const std::vector<Vec3> left = step.respond(response, backend, 1);
  EXPECT_EQ(left[0], Vec3(0, 0, -0.5));
  EXPECT_EQ(left[1], Vec3(1, 0, -0.125));
}

/// A later step that projects leaves the bone alone that is walked out of: it is in the detection, too.
TEST(ResponsesByBone, ProjectingDoesNotTouchTheBonesThatAreWalkedOutOf) {
  Shape floor = half_space(Vec3::UnitZ());
  floor.reported_depth = 0.5;
  const Shape wall = half_space(Vec3::UnitX());
  ShapeBackend backend({floor, wall});
  // In the floor alone; the wall is met by nothing.
  Step step{{Vec3(1, 0, 1)}, {Vec3(1, 0, -1)}, {}, {}};
  const std::vector<BoneResponse> of_bones{{ResponseKind::project}, {ResponseKind::backtrack}};
  EXPECT_EQ(step.respond(Response(of_bones), backend, 2)[0], Vec3(1, 0, -0.125));
  // Pushed out of the floor along a slope, into the wall: only the floor pushes.
  const Vec3 slope = Vec3(-1, 0, 1).normalized();
  Shape slanted = half_space(slope);
  slanted.reported_depth = 1;
  ShapeBackend into_wall({slanted, wall});
  Step sliding{{Vec3(0.1, 0, 1)}, {Vec3(0.1, 0, -1)}, {}, {}};
  const Vec3 out = Vec3(0.1, 0, -1) - slope.dot(Vec3(0.1, 0, -1)) * slope;
  ASSERT_LT(out.x(), 0);
  EXPECT_LT((sliding.respond(Response(of_bones), into_wall, 2)[0] - out).norm(), 1e-15);
}

}  // namespace
}  // namespace musclebench

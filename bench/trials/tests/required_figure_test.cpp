#include "bench/trials/required_figure.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "bench/cases/tests/pressed_ball.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {
namespace {

Scene balls(const std::string& keys = "", int rod_to_deg = -30, const std::string& muscles = two_balls) {
  SceneRequest request;
  request.name = request.file = "figures.toml";
  request.text = "[loop]\nframes = 6\n" + keys + "[effects.edge_length]\n" + plate_and_rod(rod_to_deg) + muscles;
  request.synthetic_mesh = [](const std::string& name) { return pressed_ball_mesh(name); };
  return read_scene(request);
}

/// Of 1000 triangles each, that touch and of which the first crosses itself by five at rest.
MuscleAtRest rest_of_two() {
  MuscleAtRest rest;
  rest.muscles = {{"ball", 0.001, 0.02, 1000}, {"other", 0.001, 0.02, 1000}};
  rest.bones = {{"plate", 0.004}, {"rod", 0}};
  rest.crossing_pairs = {{0, CrossedSurface::bone, 0, 0},
                         {0, CrossedSurface::bone, 1, 0},
                         {0, CrossedSurface::muscle, 1, 0},
                         {0, CrossedSurface::itself, 0, 0}};
  rest.crossings = {0, 0, 0, 5};
  return rest;
}

StepRecord judged_frame() {
  StepRecord frame;
  frame.frame = 4;
  frame.angle_deg = 20;
  frame.judged = true;
  frame.edge_stretch.p99 = 1.1;
  return frame;
}

const RequiredFigure& found(const std::vector<RequiredFigure>& figures, Requirement requirement) {
  const RequiredFigure* figure = find_figure(figures, requirement);
  EXPECT_NE(figure, nullptr);
  return *figure;
}

TEST(RequiredFigure, ExcessIsAFactorOfTheLimitAndCountsWhereNothingIsAllowed) {
  EXPECT_EQ((RequiredFigure{Requirement::bone_depth, 2e-4, 1e-4}.excess()), 2);
  EXPECT_EQ((RequiredFigure{Requirement::bone_passage, 0, 0}.excess()), 1);
  EXPECT_EQ((RequiredFigure{Requirement::bone_passage, 3, 0}.excess()), 4);
  EXPECT_TRUE((RequiredFigure{Requirement::bone_passage, 0, 0}.holds()));
  EXPECT_FALSE((RequiredFigure{Requirement::bone_passage, 1, 0}.holds()));
  EXPECT_FALSE((RequiredFigure{Requirement::volume, std::numeric_limits<double>::infinity(), 0.01}.holds()));
}

TEST(FiguresOfFrame, TheDeepestOfNodesSurfacesAndVerticesCounts) {
  const Scene scene = balls();
  StepRecord frame = judged_frame();
  frame.depth.max_depth_m = 1e-4;
  frame.depth_bodies = {0, 0};
  frame.surface_depth_m = 3e-4;
  frame.surface_bodies = {1, 1};
  const RequiredFigure surface = found(figures_of_frame(scene, frame, rest_of_two()), Requirement::bone_depth);
  EXPECT_EQ(surface.value, 3e-4);
  EXPECT_EQ(surface.limit, 1e-4);
  EXPECT_EQ(surface.text(), "other in the rod is 0.3 mm deep (at 20 degrees, frame 4; wanted 0.1 mm)");
  frame.thin_bone_depth_m = 5e-4;
  frame.thin_bone_bodies = {0, 1};
  EXPECT_EQ(found(figures_of_frame(scene, frame, rest_of_two()), Requirement::bone_depth).value, 5e-4);
}

/// A depth that could not be looked for everywhere is as large as it may be.
TEST(FiguresOfFrame, WhatAJudgementLeftOpenCountsByItsBound) {
  const Scene scene = balls();
  StepRecord frame = judged_frame();
  frame.surface_depth_m = 5e-5;
  frame.surface_depth_bound_m = 6e-4;
  frame.surface_bodies = {0, 0};
  EXPECT_EQ(found(figures_of_frame(scene, frame, rest_of_two()), Requirement::bone_depth).value, 5e-5);
  frame.judgement_complete = false;
  const RequiredFigure open = found(figures_of_frame(scene, frame, rest_of_two()), Requirement::bone_depth);
  EXPECT_EQ(open.value, 6e-4);
  EXPECT_NE(open.text().find("may be 0.6 mm deep"), std::string::npos) << open.text();
  EXPECT_NE(open.text().find("more substeps"), std::string::npos) << open.text();
}

/// A frame that was only followed tells of its nodes and of nothing else.
TEST(FiguresOfFrame, AFollowedFrameTellsOfItsNodes) {
  const Scene scene = balls();
  StepRecord frame = judged_frame();
  frame.judged = false;
  frame.tunnelled_nodes = 2;
  frame.beyond_rest = {0, 0, 400, 395};
  const std::vector<RequiredFigure> figures = figures_of_frame(scene, frame, rest_of_two());
  EXPECT_EQ(found(figures, Requirement::bone_passage).value, 2);
  EXPECT_EQ(find_figure(figures, Requirement::self_passage), nullptr);
  EXPECT_EQ(find_figure(figures, Requirement::whole_surface), nullptr);
}

TEST(FiguresOfFrame, CrossingsCountBeyondRestAndWhereNoDepthIsJudged) {
  const Scene scene = balls();
  MuscleAtRest rest = rest_of_two();
  StepRecord frame = judged_frame();
  frame.beyond_rest = {300, 0, 20, 9};  // in a solid bone contact is judged by depth
  const std::vector<RequiredFigure> apart = figures_of_frame(scene, frame, rest);
  EXPECT_EQ(found(apart, Requirement::self_passage).value, 9);
  EXPECT_EQ(found(apart, Requirement::self_passage).limit, 10);
  EXPECT_EQ(found(apart, Requirement::muscle_passage).value, 20);
  EXPECT_EQ(found(apart, Requirement::bone_passage).value, 0);
  rest.touching = {{0, 1}};
  EXPECT_EQ(find_figure(figures_of_frame(scene, frame, rest), Requirement::muscle_passage), nullptr);
  frame.beyond_rest = {0, 30, 0, 0};  // through a sheet
  EXPECT_EQ(found(figures_of_frame(scene, frame, rest), Requirement::bone_passage).value, 30);
}

TEST(FiguresOfFrame, NothingPassesMeansNothing) {
  const Scene scene = balls("[wanted]\nnothing_passes = true\n");
  MuscleAtRest rest = rest_of_two();
  rest.touching = {{0, 1}};
  StepRecord frame = judged_frame();
  frame.beyond_rest = {0, 0, 1, 1};
  const std::vector<RequiredFigure> figures = figures_of_frame(scene, frame, rest);
  EXPECT_FALSE(found(figures, Requirement::self_passage).holds());
  EXPECT_FALSE(found(figures, Requirement::muscle_passage).holds());
}

/// What the scene lays into each other no effect can undo.
TEST(FiguresOfFrame, MusclesMayBeAsDeepInEachOtherAsAtRest) {
  const Scene scene = balls();
  MuscleAtRest rest = rest_of_two();
  StepRecord frame = judged_frame();
  frame.depths_in_muscles_m = {0, 0, 8e-4, 0};
  EXPECT_FALSE(found(figures_of_frame(scene, frame, rest), Requirement::muscle_depth).holds());
  rest.depths_in_muscles_m = {0, 0, 8e-4, 0};
  EXPECT_TRUE(found(figures_of_frame(scene, frame, rest), Requirement::muscle_depth).holds());
  // Two of them no others.
  rest.crossing_pairs.push_back({1, CrossedSurface::muscle, 0, 0});
  rest.depths_in_muscles_m.push_back(0);
  frame.depths_in_muscles_m.push_back(3e-4);
  const RequiredFigure other = found(figures_of_frame(scene, frame, rest), Requirement::muscle_depth);
  EXPECT_FALSE(other.holds());
  EXPECT_EQ(other.text(), "other in ball is 0.3 mm deep (at 20 degrees, frame 4; wanted 0.1 mm)");
}

/// A run of made-up frames whose muscle ends `moved_m` from where it began.
RunResult run_of(const Scene& scene, double moved_m) {
  RunResult run;
  run.rest = rest_of_two();
  run.records = {judged_frame()};
  run.outcome.max_volume_error = 0.02;
  run.start_positions = scene.muscle_mesh.vertices;
  for (const Vec3& vertex : scene.muscle_mesh.vertices) run.end_positions.push_back(vertex + Vec3(0, moved_m, 0));
  return run;
}

TEST(FiguresOfRun, AShapeReturnsWhereBonesDoOrWhereThatIsAskedFor) {
  const auto has_return = [](const Scene& scene) {
    return find_figure(figures_of_run(scene, run_of(scene, 3e-3)), Requirement::returned_shape) != nullptr;
  };
  EXPECT_FALSE(has_return(balls()));  // its rod goes there and stays
  EXPECT_FALSE(has_return(balls("", 0)));
  const Scene asked = balls("[wanted]\nreturns_mm = 1\n", 0);
  ASSERT_TRUE(has_return(asked));
  const RequiredFigure figure = found(figures_of_run(asked, run_of(asked, 3e-3)), Requirement::returned_shape);
  EXPECT_NEAR(figure.value, 3e-3, 1e-12);
  EXPECT_EQ(figure.text(), "ball ends 3 mm (RMS) from where it began (frame 6; wanted 1 mm)");
}

TEST(FiguresOfRun, ADivergedRunHoldsNothingAndAnInvertedOneHasNoVolume) {
  const Scene scene = balls();
  RunResult run = run_of(scene, 0);
  EXPECT_EQ(found(figures_of_run(scene, run), Requirement::volume).value, 0.02);
  run.status = "diverged";
  run.outcome.turned_inside_out = true;
  const std::vector<RequiredFigure> figures = figures_of_run(scene, run);
  EXPECT_FALSE(found(figures, Requirement::whole_surface).holds());
  EXPECT_FALSE(found(figures, Requirement::trusted_run).holds());
  EXPECT_TRUE(std::isinf(found(figures, Requirement::volume).value));
}

TEST(FiguresOfRun, AFrameWhoseFigureIsNoNumberIsTheWorst) {
  const Scene scene = balls();
  RunResult run = run_of(scene, 0);
  run.records.push_back(judged_frame());
  run.records.back().edge_stretch.p99 = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(found(figures_of_run(scene, run), Requirement::whole_surface).holds());
}

/// Lengths of a frame's only fibre.
FibreFrame fibre_frame(int frame, double length_m) { return {frame, 0.1 * frame, {{{length_m}, {}}, {{0.1}, {}}}}; }

TEST(FiguresOfRun, FibresAreTautWhereArmsAreWantedAndNothingGetsShorter) {
  Scene scene = balls();
  RunResult run = run_of(scene, 0);
  run.fibres = {fibre_frame(0, 0.1), fibre_frame(1, 0.1), fibre_frame(2, 0.08)};
  EXPECT_EQ(find_figure(figures_of_run(scene, run), Requirement::taut_fibres), nullptr);
  scene.wanted.moment_arm_m = 1e-3;
  const RequiredFigure slack = found(figures_of_run(scene, run), Requirement::taut_fibres);
  EXPECT_NEAR(slack.value, 0.2, 1e-12);
  EXPECT_EQ(slack.where, "ball");
  run.fibres.pop_back();
  EXPECT_TRUE(found(figures_of_run(scene, run), Requirement::taut_fibres).holds());
  run.fibres.clear();  // what can't be told is not taut
  EXPECT_FALSE(found(figures_of_run(scene, run), Requirement::taut_fibres).holds());
}

TEST(LargestRmsDistance, IsThatOfTheMuscleThatMovedMost) {
  const std::vector<Body> bodies{{"still", 0, 2, 0, 0}, {"moved", 2, 4, 0, 0}};
  const std::vector<Vec3> from(4, Vec3::Zero());
  const std::vector<Vec3> to{Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(0, 4, 0)};
  const LargestDistance largest = largest_rms_distance(bodies, from, to);
  EXPECT_EQ(largest.body, 1U);
  EXPECT_NEAR(largest.distance_m, std::sqrt(12.5), 1e-12);
}

}  // namespace
}  // namespace musclebench

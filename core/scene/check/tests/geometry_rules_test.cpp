#include <cmath>

#include "core/effects/effect_registry.hpp"
#include "core/scene/check/compression.hpp"
#include "core/scene/check/muscle_gap.hpp"
#include "core/scene/check/pinch.hpp"
#include "core/scene/check/ridge_depth.hpp"
#include "core/scene/check/step_against_thickness.hpp"
#include "core/scene/check/tests/check_fixture.hpp"

namespace musclebench {
namespace {

Scene plate_beside_a_ball(double step_deg, const std::string& effects) {
  return check_scene_of(short_loop + bone_text("plate", turning(10 * step_deg)) + muscle_text("ball") +
                        "[effects.edge_length]\n" + effects);
}

TEST(StepAgainstThickness, IsThatOfAPlate) {
  const StepAgainstThickness found = step_against_thickness(plate_beside_a_ball(1, ""), 0);
  EXPECT_NEAR(found.thinner.thinnest_m, 0.004, 1e-6);
  // The part of the plate near the ball is about 60 mm from the axis.
  EXPECT_NEAR(found.step_m, 0.06 * 3.14159265 / 180, 2e-4);
  EXPECT_EQ(found.thinner.share, 0);
}

TEST(ThinShare, IsThatOfTheArea) {
  const std::vector<ThicknessSample> samples = {{0.001, 3}, {0.002, 1}, {0.004, 4}};
  EXPECT_EQ(share_thinner_than(0.002, samples).share, 0.375);
  EXPECT_EQ(share_thinner_than(0.002, samples).thinnest_m, 0.001);
  EXPECT_EQ(share_thinner_than(1, {}).share, 0);
}

TEST(GeometryRules, AskForAGuardWhereAStepIsLongerThanABoneIsThick) {
  const auto asks = [](double step_deg, const std::string& effects) {
    const Findings findings = check_scene(plate_beside_a_ball(step_deg, effects));
    const Finding* finding = find_finding(findings, "tunnelling_guard");
    if (finding == nullptr) return false;
    EXPECT_EQ(finding->where, "bone 'plate'");
    EXPECT_NEAR(figure_of(*finding, "thinnest_m"), 0.004, 1e-6);
    EXPECT_EQ(finding->effect->name, "tunnelling_guard");
    return true;
  };
  EXPECT_TRUE(asks(6, ""));   // 6 mm
  EXPECT_FALSE(asks(2, ""));  // 2 mm
  EXPECT_FALSE(asks(6, "[effects.tunnelling_guard]\n"));
}

TEST(GeometryRules, AskForAVolumeWhereNoneIsKept) {
  EXPECT_TRUE(is_found(plate_beside_a_ball(1, ""), "volume"));
  EXPECT_FALSE(is_found(plate_beside_a_ball(1, "[effects.volume]\n"), "volume"));
  EXPECT_FALSE(is_found(plate_beside_a_ball(1, "[effects.local_volume]\n"), "volume"));
  const std::string open = bone_text("plate", turning(1)) + muscle_text("bowl") + "[effects.edge_length]\n";
  EXPECT_FALSE(is_found(check_scene_of(open), "volume")) << "nothing could keep it";
}

TEST(CutDepth, IsTheSagittaOfASphere) {
  const TriangleBvh sphere(make_sphere(0.02, 5));  // facets of 0.7 mm are bumps of some micrometres
  for (const double edge_m : {0.002, 0.01}) {
    const double sagitta_m = 0.02 - std::sqrt(0.02 * 0.02 - 0.25 * edge_m * edge_m);
    EXPECT_NEAR(cut_depth_m(sphere, Vec3(0.02, 0, 0), Vec3::UnitX(), edge_m), sagitta_m, 0.03 * sagitta_m + 6e-6);
  }
}

TEST(CutDepth, IsThatOfARoofAndNoneOfAPlane) {
  const TriangleBvh box(make_box(Vec3(0.02, 0.02, 0.02), 1));
  const Vec3 diagonal = Vec3(1, 0, 1).normalized();
  // Both sides of a right angle fall by 45 degrees; an edge lies across within 15 degrees of the best direction.
  EXPECT_NEAR(cut_depth_m(box, Vec3(0.02, 0, 0.02), diagonal, 0.004), 0.002, 0.035 * 0.002);
  EXPECT_NEAR(cut_depth_m(box, Vec3(0.003, 0.001, 0.02), Vec3::UnitZ(), 0.004), 0, 1e-12);
}

TEST(GeometryRules, AskForSurfaceContactOverRidgesAndNotOverFlats) {
  // The ball's lowest point is over the middle of a face, or over the edge between two.
  const auto finding_over = [](double shift_m, const std::string& effects) {
    Scene scene = check_scene_of(bone_text("block") + muscle_text("ball") + "[effects.edge_length]\n" + effects);
    for (Vec3& vertex : scene.muscle_mesh.vertices) vertex.x() += shift_m;
    const Findings findings = check_scene(scene);
    const Finding* finding = find_finding(findings, "surface_contact");
    return finding == nullptr ? std::optional<double>() : figure_of(*finding, "cut_depth_m");
  };
  EXPECT_FALSE(finding_over(0, ""));
  const auto depth_m = finding_over(0.02, "");
  ASSERT_TRUE(depth_m);
  EXPECT_GT(*depth_m, 3e-4);
  EXPECT_FALSE(finding_over(0.02, "[effects.surface_contact]\n"));
}

/// A ball between two plates that are bound to it; the lid comes down onto it by `lower_deg`.
std::string pressed_ball(double lower_deg) {
  return short_loop + bone_text("plate") +
         bone_text("lid", fmt::format("[bone.motion]\naxis = [0, 1, 0]\ncentre_m = [-0.1, 0, 0]\nfrom_deg = 0\n"
                                      "to_deg = {}\n",
                                      lower_deg)) +
         muscle_text("ball") + attachment_text("plate", "ball", 0.0015) +
         attachment_text("lid", "ball", 0.0025, 0.024) + "[effects.attachment]\n[effects.edge_length]\n";
}

TEST(PoseEstimates, BoundNodesFollowTheirBonesAndOthersGoBetween) {
  const Scene scene = check_scene_of(pressed_ball(6));
  const PoseEstimates poses(scene);
  EXPECT_EQ(poses.count(), 9U) << "there and back, each pose once";
  const std::size_t last = poses.count() - 1;
  EXPECT_NEAR(poses.angle_rad(last), 6 / degrees_per_radian, 1e-9);
  std::vector<char> is_bound(scene.muscle_mesh.vertices.size(), 0);
  for (const BoundNode& bound : scene.bound_nodes()) {
    const auto node = static_cast<std::size_t>(bound.node);
    is_bound[node] = 1;
    const Vec3 expected =
        poses.bone_poses(last)[static_cast<std::size_t>(bound.bone)].apply(scene.muscle_mesh.vertices[node]);
    EXPECT_LT((poses.position(last, bound.node) - expected).norm(), 1e-12);
  }
  for (std::size_t node = 0; node < is_bound.size(); ++node) {
    const Vec3& rest = scene.muscle_mesh.vertices[node];
    const double moved_m = (poses.position(last, static_cast<int>(node)) - rest).norm();
    const double with_lid_m = (poses.bone_poses(last)[1].apply(rest) - rest).norm();
    EXPECT_LE(moved_m, with_lid_m + 1e-12);
    EXPECT_TRUE(is_bound[node] != 0 || moved_m > 0);
    EXPECT_LT((poses.position(0, static_cast<int>(node)) - rest).norm(), 1e-12);
  }
}

TEST(GeometryRules, AskForSeveralBonesWhereAMuscleIsPinched) {
  const auto pinch = [](double lower_deg, const std::string& effects) {
    const Findings findings = check_scene(check_scene_of(pressed_ball(lower_deg) + effects));
    const Finding* finding = find_finding(findings, "multi_bone", "bones 'plate' and 'lid'");
    return finding == nullptr ? std::optional<double>() : figure_of(*finding, "room_m");
  };
  EXPECT_FALSE(pinch(1, ""));        // the room is 20 mm for a ball of 20
  const auto room_m = pinch(8, "");  // lowered by 14 mm
  ASSERT_TRUE(room_m);
  EXPECT_LT(*room_m, 0.011);
  EXPECT_FALSE(pinch(8, "[effects.multi_bone]\n"));
}

TEST(Pinches, AreOfAMuscleThatHasABoneOnEitherSide) {
  const Scene scene = check_scene_of(pressed_ball(8));
  const PoseEstimates poses(scene);
  const std::vector<double> thickness_m = node_thicknesses_m(scene);
  std::vector<BoneNearness> nearness = bone_nearness(scene, poses, thickness_m);
  ASSERT_EQ(pinches(poses, nearness, thickness_m).size(), 1U);
  // A muscle that looks along both bones lies before the gap between them.
  for (BoneNearness& bone : nearness) {
    for (NearNode& near : bone.near) near.muscle_normal = near.normal.unitOrthogonal();
  }
  EXPECT_TRUE(pinches(poses, nearness, thickness_m).empty());
}

TEST(Compression, IsThatOfABallBetweenPlatesThatCloseIn) {
  const auto ratio = [](double lower_deg) {
    const Scene scene = check_scene_of(pressed_ball(lower_deg));
    return compressions(scene, PoseEstimates(scene)).front();
  };
  EXPECT_EQ(ratio(0).edge_ratio, 1);
  EXPECT_LT(ratio(2).edge_ratio, 0.95);
  EXPECT_LT(ratio(4).edge_ratio, ratio(2).edge_ratio);
  EXPECT_NEAR(ratio(4).angle_rad, 4 / degrees_per_radian, 1e-9);
  EXPECT_EQ(ratio(-4).edge_ratio > 0.95, true) << "drawn apart";
}

TEST(GeometryRules, AskForSelfContactWhereABuildHasIt) {
  const bool has = find_effect("self_contact") != nullptr;
  EXPECT_EQ(is_found(check_scene_of(pressed_ball(4)), "self_contact", "muscle 'ball'"), has);
  EXPECT_FALSE(is_found(check_scene_of(pressed_ball(-4)), "self_contact"));
  if (has) {
    EXPECT_FALSE(is_found(check_scene_of(pressed_ball(4) + "[effects.self_contact]\n"), "self_contact"));
    const std::string bending = "[effects.bending]\ncompliance_rad_per_n_m = ";
    EXPECT_FALSE(is_found(check_scene_of(pressed_ball(4) + bending + "1e4\n"), "self_contact"));
    EXPECT_TRUE(is_found(check_scene_of(pressed_ball(4) + bending + "1e7\n"), "self_contact"));
  }
}

Scene two_muscles(const std::string& second, const std::string& more = "") {
  return check_scene_of(bone_text("plate", turning(1)) + muscle_text("ball") + muscle_text(second) +
                        "[effects.edge_length]\n" + more);
}

TEST(MuscleGaps, AreExactAtRest) {
  const auto gap_of = [](double shift_m) {
    Scene scene = two_muscles("far");
    const Body& far = scene.muscles[1].body;
    for (int node = far.first_node; node < far.last_node; ++node) {
      scene.muscle_mesh.vertices[static_cast<std::size_t>(node)].x() -= shift_m;
    }
    return muscle_gaps(scene, PoseEstimates(scene), 0.005);
  };
  EXPECT_TRUE(gap_of(0).empty());
  ASSERT_EQ(gap_of(0.079).size(), 1U);
  EXPECT_NEAR(gap_of(0.079).front().rest_m, 0.001, 1e-4);  // poles of the spheres are vertices
  EXPECT_EQ(gap_of(0.079).front().rest_nodes_inside, 0);
  EXPECT_NEAR(gap_of(0.083).front().rest_m, -0.003, 2e-4);
  EXPECT_GT(gap_of(0.083).front().rest_nodes_inside, 0);
}

TEST(GeometryRules, AskForContactOfMusclesThatTouchOrWill) {
  const Findings findings = check_scene(two_muscles("other"));
  const Finding* finding = find_finding(findings, "muscle_contact", "muscles 'ball' and 'other'");
  ASSERT_NE(finding, nullptr);
  EXPECT_LT(figure_of(*finding, "rest_gap_m"), -0.004);
  EXPECT_EQ(finding->muscle_pair, (MusclePair{0, 1}));
  EXPECT_FALSE(is_found(two_muscles("far"), "muscle_contact"));
  EXPECT_FALSE(is_found(two_muscles("other", "[contact]\nmuscle_contact = true\n"), "muscle_contact"));
  // The far one is bound to a plate that turns by half a turn about an axis between the two.
  const std::string text = bone_text("plate",
                                     "[bone.motion]\naxis = [0, 1, 0]\ncentre_m = [0.05, 0, 0.0125]\n"
                                     "from_deg = 0\nto_deg = 180\n") +
                           muscle_text("ball") + muscle_text("far");
  const std::string bound =
      "[[attachment]]\nname = \"all\"\nbone = \"plate\"\nmuscle = \"far\"\ndistance_m = 1\nmargin_m = 1\n"
      "outline_m = [[-0.02, -0.02, 0.002], [0.02, -0.02, 0.002], [0.02, 0.02, 0.002], [-0.02, 0.02, 0.002]]\n";
  EXPECT_FALSE(is_found(check_scene_of(text), "muscle_contact"));
  const Findings later = check_scene(check_scene_of(text + bound));
  const Finding* will = find_finding(later, "muscle_contact");
  ASSERT_NE(will, nullptr);
  EXPECT_NE(will->what.find("would overlap"), std::string::npos) << will->what;
  EXPECT_GT(figure_of(*will, "rest_gap_m"), 0);
}

TEST(GeometryRules, TellWhatGoesThroughEachOtherBeforeAnythingIsHeldApart) {
  const std::string guard = "[effects.no_passage]\n";
  EXPECT_FALSE(is_found(two_muscles("far", guard), "passed_at_start"));
  EXPECT_FALSE(is_found(two_muscles("other"), "passed_at_start")) << "not asked for";
  const Findings findings = check_scene(two_muscles("other", guard));
  const Finding* finding = find_finding(findings, "passed_at_start", "effects.no_passage, muscle 'ball'");
  ASSERT_NE(finding, nullptr);
  EXPECT_EQ(finding->kind, FindingKind::acts_in_part);
  EXPECT_GT(figure_of(*finding, "triangles"), 10);
  EXPECT_NE(finding->what.find("muscle 'other'"), std::string::npos) << finding->what;
  // The other effect for that is not called for.
  EXPECT_FALSE(is_found(two_muscles("other", guard), "muscle_contact"));
  // The ball hangs 0.5 mm above the plate; turned from the start, the plate goes through it.
  const auto plate_turned = [&](double degrees) {
    return check_scene_of(bone_text("plate", fmt::format("[bone.motion]\naxis = [0, 1, 0]\ncentre_m = [-0.05, 0, 0]\n"
                                                         "from_deg = {}\nto_deg = {}\n",
                                                         degrees, degrees)) +
                          muscle_text("ball") + guard);
  };
  EXPECT_FALSE(is_found(plate_turned(0), "passed_at_start"));
  const Findings turned = check_scene(plate_turned(-3));
  const Finding* through = find_finding(turned, "passed_at_start");
  ASSERT_NE(through, nullptr);
  EXPECT_NE(through->what.find("bone 'plate'"), std::string::npos) << through->what;
}

TEST(GeometryRules, OfOpenMusclesContactIsNotAdded) {
  const Scene scene = check_scene_of(bone_text("plate", turning(1)) + muscle_text("bowl") + muscle_text("other"));
  const Findings findings = check_scene(scene);
  const Finding* finding = find_finding(findings, "muscle_contact");
  ASSERT_NE(finding, nullptr);
  EXPECT_FALSE(finding->muscle_pair);
  EXPECT_NE(finding->what.find("closed"), std::string::npos);
}

TEST(GeometryRules, FindCellsLargerThanTheGap) {
  const auto finds = [](double error_m, bool misses) {
    CheckOptions options;
    options.cells = {{"grid", error_m, error_m, misses, "cells"}};
    const Findings findings = check_scene(plate_beside_a_ball(1, "[effects.volume]\n"), options);
    const Finding* finding = find_finding(findings, "grid_cells", "bone 'plate', backend 'grid'");
    if (finding == nullptr) return std::string("nothing");
    EXPECT_NEAR(figure_of(*finding, "rest_gap_m"), 0.0005, 1e-5);
    EXPECT_NE(finding->what.find("--param cells="), std::string::npos);
    const Finding* margin = find_finding(findings, "margin", "bone 'plate'");
    EXPECT_FALSE(margin != nullptr && margin->effect) << "nothing adds it unasked";
    return margin == nullptr ? std::string("finer cells") : margin->add.front();
  };
  EXPECT_EQ(finds(0, false), "nothing");
  EXPECT_EQ(finds(0.0004, false), "nothing");
  EXPECT_EQ(finds(0.002, false), "finer cells");
  EXPECT_EQ(finds(0.002, true), "[effects.margin]");
}

TEST(GeometryRules, FindABoneThinnerThanTwoCells) {
  const auto finds = [](double cell_m, bool misses) {
    CheckOptions options;
    options.cells = {{"grid", cell_m, 0, misses, "cells"}};
    const Findings findings = check_scene(plate_beside_a_ball(1, "[effects.volume]\n"), options);
    const Finding* finding = find_finding(findings, "feature_thinner_than_cell", "bone 'plate', backend 'grid'");
    if (finding != nullptr) {
      EXPECT_NEAR(figure_of(*finding, "thinnest_m"), 0.004, 1e-6);
    }
    return finding != nullptr;
  };
  EXPECT_TRUE(finds(0.003, true));
  EXPECT_FALSE(finds(0.0019, true));
  EXPECT_FALSE(finds(0.003, false)) << "cells that only sort exact answers";
}

TEST(GeometryRules, FindContactThatCanNotBe) {
  const auto out_of_reach = [](const std::string& muscle, const std::string& effects, const std::string& more = "") {
    return is_found(check_scene_of(bone_text("plate", turning(1)) + muscle_text(muscle, more) +
                                   "[effects.edge_length]\n" + effects),
                    "out_of_reach", "effects.friction");
  };
  EXPECT_TRUE(out_of_reach("far", "[effects.friction]\n"));
  EXPECT_FALSE(out_of_reach("far", "[effects.friction]\n[effects.gravity]\n"));
  EXPECT_FALSE(out_of_reach("far", "[effects.friction]\n[effects.self_contact]\n"));
  EXPECT_FALSE(out_of_reach("ball", "[effects.friction]\n"));
  EXPECT_FALSE(out_of_reach("far", ""));
  EXPECT_FALSE(out_of_reach("far", "[effects.friction]\n", "velocity_m_per_s = [0, 0, -1]\n")) << "it may fly there";
}

TEST(GeometryRules, FindASkinThickerThanTheMuscle) {
  const auto thick = [](double thickness_m) {
    return is_found(plate_beside_a_ball(1, fmt::format("[effects.margin]\nthickness_m = {}\n", thickness_m)),
                    "thick_margin", "effects.margin.thickness_m");
  };
  EXPECT_TRUE(thick(0.03));
  EXPECT_FALSE(thick(0.001));
}

TEST(GeometryRules, FindASelfContactThatLeavesTheMuscleOut) {
  const auto thick = [](double thickness_m) {
    return is_found(plate_beside_a_ball(1, fmt::format("[effects.self_contact]\nthickness_m = {}\n", thickness_m)),
                    "thick_self_contact", "effects.self_contact.thickness_m");
  };
  EXPECT_TRUE(thick(0.006));
  EXPECT_FALSE(thick(0.001));
  EXPECT_FALSE(thick(0));
}

}  // namespace
}  // namespace musclebench

// The search with runs that are made up: which figures a set of effects leaves is known, and so is what it should find.
#include "bench/trials/effect_search.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "bench/cases/tests/pressed_ball.hpp"
#include "core/scene/check/auto_effects.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {
namespace {

constexpr double deep_m = 2e-3;
constexpr const char* whole_ball = "[effects.edge_length]\n[effects.volume]\n";

Scene scene_of(const std::string& effects, const std::string& muscles = one_ball) {
  SceneRequest request;
  request.name = request.file = "made_up.toml";
  request.text = "[loop]\nframes = 6\n" + effects + plate_and_rod(-30) + muscles;
  request.synthetic_mesh = [](const std::string& name) { return pressed_ball_mesh(name); };
  return read_scene(request);
}

/// A figure that is 1 at its limit where it holds.
RequiredFigure figure(Requirement requirement, double value, double limit) {
  return {requirement, value, limit, "ball in the plate", {3, 12}};
}

/// What a run with these effects leaves: depth, nodes through a bone, volume.
using MadeUp = std::function<std::vector<RequiredFigure>(const Scene& scene)>;

std::vector<std::string> changes_of(const EffectChoice& choice) {
  std::vector<std::string> changes;
  for (const TriedSet& tried : choice.tried) changes.push_back(tried.change);
  return changes;
}

std::vector<std::string> names_of(const std::vector<AddedEffect>& added) {
  std::vector<std::string> names;
  for (const AddedEffect& each : added) names.push_back(each.effect);
  return names;
}

EffectChoice searched(Scene& scene, const MadeUp& made_up, bool looks_for_needless = false) {
  const TryScene run = [&](const Scene& tried, const TrialRequest& request, const std::string& /*what*/) {
    EffectTrial trial;
    trial.figures = made_up(tried);
    trial.was_stopped = std::ranges::any_of(trial.figures, [&](const RequiredFigure& each) {
      // A volume is told by the whole run.
      return each.requirement != Requirement::volume && request.shows_enough && request.shows_enough(each);
    });
    const Vec3 moved = has_effect(tried, "gravity") ? Vec3(0, 0, 1) : Vec3(0, 0, 0);
    trial.shapes.assign(2, std::vector<Vec3>(tried.muscle_mesh.vertices.size(), moved));
    trial.cpu_ns = 1;
    trial.judged_all_frames = true;
    return trial;
  };
  return choose_effects(scene, run, {.looks_for_needless = looks_for_needless});
}

double depth_m(const Scene& scene, const std::string& remedy, double with_m) {
  return has_effect(scene, remedy) ? with_m : deep_m;
}

using Names = std::vector<std::string>;

TEST(EffectSearch, ASceneThatHoldsIsRunOnceAndLeftAlone) {
  Scene scene = scene_of(whole_ball);
  const EffectChoice choice =
      searched(scene, [](const Scene&) { return std::vector{figure(Requirement::bone_depth, 1e-5, 1e-4)}; });
  EXPECT_TRUE(choice.holds());
  EXPECT_TRUE(choice.added.empty());
  EXPECT_EQ(changes_of(choice), Names{"as it is"});
  EXPECT_EQ(choice.tried.front().verdict, "holds all that is wanted");
}

TEST(EffectSearch, WhatMendsIsAddedWithItsFigures) {
  Scene scene = scene_of(whole_ball);
  const EffectChoice choice = searched(scene, [](const Scene& tried) {
    return std::vector{figure(Requirement::bone_depth, depth_m(tried, "surface_contact", 2e-5), 1e-4)};
  });
  EXPECT_TRUE(choice.holds());
  ASSERT_EQ(names_of(choice.added), Names{"surface_contact"});
  EXPECT_TRUE(has_effect(scene, "surface_contact"));
  EXPECT_EQ(choice.added.front().rule, "trial");
  EXPECT_EQ(choice.added.front().reason,
            "when it was tried, without it ball in the plate is 2 mm deep (at 12 degrees, frame 3; wanted 0.1 mm), "
            "with it 0.02 mm");
  EXPECT_EQ(choice.cpu_ns, static_cast<Nanoseconds>(choice.tried.size()));
}

/// Contact of surfaces holds the depth and lets nodes through: the next one is taken.
TEST(EffectSearch, WhatSpoilsAsMuchAsItMendsIsNotTaken) {
  Scene scene = scene_of(whole_ball);
  const EffectChoice choice = searched(scene, [](const Scene& tried) {
    const double nodes = has_effect(tried, "surface_contact") ? 400 : 0;
    const bool is_held = has_effect(tried, "surface_contact") || has_effect(tried, "no_passage");
    return std::vector{figure(Requirement::bone_passage, nodes, 0),
                       figure(Requirement::bone_depth, is_held ? 0 : deep_m, 1e-4)};
  });
  EXPECT_EQ(names_of(choice.added), Names{"no_passage"});
  EXPECT_TRUE(choice.holds());
}

TEST(EffectSearch, WhatSpoilsAsMuchByTheEndIsNotTakenEither) {
  Scene scene = scene_of("[effects]\nlocal_volume = false\n[effects.edge_length]\n[effects.volume]\n");
  const EffectChoice choice = searched(scene, [](const Scene& tried) {
    const bool is_held = has_effect(tried, "surface_contact");
    return std::vector{figure(Requirement::volume, is_held ? 2 : 0.001, 0.01),
                       figure(Requirement::bone_depth, is_held ? 0 : deep_m, 1e-4)};
  });
  EXPECT_TRUE(choice.added.empty());
  EXPECT_EQ(choice.unmet.size(), 1U);
}

/// Nodes no longer pass, for a volume that is off by a little: that is taken, and told.
TEST(EffectSearch, WhatMendsMuchMaySpoilALittle) {
  Scene scene = scene_of("[effects]\nlocal_volume = false\n[effects.edge_length]\n[effects.volume]\n");
  const EffectChoice choice = searched(scene, [](const Scene& tried) {
    const bool is_guarded = has_effect(tried, "tunnelling_guard");
    return std::vector{figure(Requirement::volume, is_guarded ? 0.0116 : 0.001, 0.01),
                       figure(Requirement::bone_passage, is_guarded ? 0 : 600, 0)};
  });
  EXPECT_EQ(names_of(choice.added), Names{"tunnelling_guard"});
  ASSERT_EQ(choice.unmet.size(), 1U);
  EXPECT_NE(choice.unmet.front().text().find("off by 1.16 %"), std::string::npos) << choice.unmet.front().text();
}

TEST(EffectSearch, WhatLeavesARunThatDivergesMendsNothing) {
  Scene scene = scene_of(whole_ball);
  const EffectChoice choice = searched(
      scene,
      [](const Scene& tried) {
        return std::vector{figure(Requirement::whole_surface, std::numeric_limits<double>::infinity(), 3),
                           figure(Requirement::bone_depth, depth_m(tried, "surface_contact", 0), 1e-4)};
      },
      true);
  EXPECT_TRUE(choice.added.empty());
  EXPECT_TRUE(choice.needless.empty());
  EXPECT_FALSE(choice.holds());
}

/// What was added first does nothing once the second is there.
TEST(EffectSearch, WhatBecameNeedlessIsTakenAwayAgain) {
  Scene scene = scene_of(whole_ball);
  const EffectChoice choice = searched(scene, [](const Scene& tried) {
    const bool is_whole = has_effect(tried, "no_passage");
    const bool is_guarded = has_effect(tried, "tunnelling_guard");
    return std::vector{figure(Requirement::bone_passage, is_guarded || is_whole ? 0 : 9, 0),
                       figure(Requirement::bone_depth, is_whole ? 0 : deep_m, 1e-4)};
  });
  EXPECT_EQ(names_of(choice.added), Names{"no_passage"});
  EXPECT_EQ(changes_of(choice).back(), "- tunnelling_guard");
  EXPECT_FALSE(has_effect(scene, "tunnelling_guard"));
}

/// Two that halve the depth each: both stay, and what is left is told.
TEST(EffectSearch, WhatHelpsInPartStaysAndTheRestIsTold) {
  Scene scene = scene_of(whole_ball);
  const EffectChoice choice = searched(scene, [](const Scene& tried) {
    double left_m = deep_m;
    for (const char* effect : {"multi_bone", "surface_contact"}) left_m *= has_effect(tried, effect) ? 0.4 : 1;
    return std::vector{figure(Requirement::bone_depth, left_m, 1e-4)};
  });
  EXPECT_EQ(names_of(choice.added), (Names{"surface_contact", "multi_bone"}));  // the checker advises the first
  ASSERT_EQ(choice.unmet.size(), 1U);
  EXPECT_NE(choice.unmet.front().text().find("0.32 mm deep"), std::string::npos) << choice.unmet.front().text();
  EXPECT_NE(choice.unmet.front().text().find("no_passage, which was ended in frame 0, leaves 0.32 mm"),
            std::string::npos)
      << choice.unmet.front().text();
}

TEST(EffectSearch, WhatTheSceneKeepsOutStaysOut) {
  Scene scene =
      scene_of("[effects]\nsurface_contact = false\nno_passage = false\n[effects.edge_length]\n[effects.volume]\n");
  const EffectChoice choice = searched(scene, [](const Scene& tried) {
    return std::vector{figure(Requirement::bone_depth, depth_m(tried, "surface_contact", 0), 1e-4)};
  });
  EXPECT_TRUE(choice.added.empty());
  EXPECT_FALSE(choice.holds());
}

/// A rule needs no run to see that nothing holds the surface; a run shows whether that matters.
TEST(EffectSearch, WhatRulesAskForIsAddedAtOnceAndLeftOutIfNothingFeelsIt) {
  for (const bool is_felt : {true, false}) {
    Scene scene = scene_of("[effects.gravity]\n");
    const EffectChoice choice = searched(scene, [is_felt](const Scene& tried) {
      const bool is_torn = is_felt && !has_effect(tried, "edge_length");
      return std::vector{figure(Requirement::whole_surface, is_torn ? 20 : 1, 3)};
    });
    EXPECT_EQ(names_of(choice.added), is_felt ? Names{"edge_length"} : Names{}) << is_felt;
    EXPECT_EQ(has_effect(scene, "edge_length"), is_felt);
  }
}

TEST(EffectSearch, MusclesThatMeetGetContact) {
  std::string apart = two_balls;
  apart.erase(apart.find("[contact]"));
  Scene scene = scene_of(whole_ball, apart);
  ASSERT_TRUE(scene.muscle_pairs.empty());
  const EffectChoice choice = searched(scene, [](const Scene& tried) {
    return std::vector{figure(Requirement::muscle_passage, tried.muscle_pairs.empty() ? 90 : 0, 2)};
  });
  EXPECT_EQ(names_of(choice.added), Names{"muscle_contact ball other"});
  EXPECT_EQ(scene.muscle_pairs.size(), 1U);
}

/// The order of the muscles is no matter.
TEST(EffectSearch, AllPairsAreTriedWhereTheCheckerExpectsNone) {
  std::string three = two_balls;
  three.erase(three.find("[contact]"));
  three += "[[muscle]]\nname = \"far\"\nmesh = \"synthetic:other\"\ntranslate_m = [0.5, 0, 0]\n";
  Scene scene = scene_of(whole_ball, three);
  const EffectChoice choice = searched(scene, [](const Scene& tried) {
    const bool touch = std::ranges::any_of(tried.muscle_pairs, [](const SceneMusclePair& pair) {
      return pair.muscles == MusclePair{1, 2};
    });
    return std::vector{figure(Requirement::muscle_passage, touch ? 0 : 90, 2)};
  });
  EXPECT_EQ(names_of(choice.added), Names{"muscle_contact other far"});
}

/// Contact that leaves muscles deep in each other mends nothing: nobody had judged that depth before.
TEST(EffectSearch, WhatAnAdditionBringsWithItCounts) {
  std::string apart = two_balls;
  apart.erase(apart.find("[contact]"));
  Scene scene = scene_of("[effects]\nno_passage = false\n[effects.edge_length]\n[effects.volume]\n", apart);
  const EffectChoice choice = searched(scene, [](const Scene& tried) {
    std::vector figures{figure(Requirement::muscle_passage, tried.muscle_pairs.empty() ? 9 : 0, 0)};
    if (!tried.muscle_pairs.empty()) figures.push_back(figure(Requirement::muscle_depth, 5e-3, 1e-4));
    return figures;
  });
  EXPECT_TRUE(choice.added.empty());
}

/// Two volumes with two targets can't be: what the scene contradicts is not run.
TEST(EffectSearch, WhatContradictsTheSceneIsNotRun) {
  Scene scene = scene_of("[effects.edge_length]\n[effects.volume]\npressure = 1.2\n");
  const EffectChoice choice = searched(scene, [](const Scene& tried) {
    return std::vector{figure(Requirement::volume, has_effect(tried, "local_volume") ? 0 : 0.2, 0.01)};
  });
  EXPECT_TRUE(choice.added.empty());
  EXPECT_NE(choice.unmet.front().text().find("local_volume is not run"), std::string::npos)
      << choice.unmet.front().text();
}

/// Folds that self_contact mends only once faces are out of the bone, which is looked after later.
TEST(EffectSearch, WhatCouldNotBeMendedIsTriedAgain) {
  Scene scene = scene_of(whole_ball);
  const EffectChoice choice = searched(scene, [](const Scene& tried) {
    const bool is_out = has_effect(tried, "surface_contact");
    const bool is_unfolded = is_out && has_effect(tried, "self_contact");
    return std::vector{figure(Requirement::self_passage, is_unfolded ? 0 : 60, 0),
                       figure(Requirement::bone_depth, is_out ? 0 : deep_m, 1e-4)};
  });
  EXPECT_EQ(names_of(choice.added), (Names{"surface_contact", "self_contact"}));
  EXPECT_TRUE(choice.holds());
}

/// What is told is of the scene as it was left.
TEST(EffectSearch, WhatDoesNotHoldIsToldAsItIsInTheEnd) {
  Scene scene = scene_of(whole_ball);
  const EffectChoice choice = searched(scene, [](const Scene& tried) {
    const bool is_guarded = has_effect(tried, "tunnelling_guard");
    return std::vector{figure(Requirement::whole_surface, is_guarded ? 4 : 9, 3),
                       figure(Requirement::bone_passage, is_guarded ? 0 : 60, 0)};
  });
  ASSERT_EQ(choice.unmet.size(), 1U);
  EXPECT_NE(choice.unmet.front().text().find("is 4 times"), std::string::npos) << choice.unmet.front().text();
}

/// The few frames that were judged held: all of them show more.
TEST(EffectSearch, TheEndIsJudgedInAllFrames) {
  for (const bool judges_the_end : {true, false}) {
    Scene scene = scene_of(whole_ball);
    const EffectChoice choice =
        choose_effects(scene,
                       [](const Scene& tried, const TrialRequest& request, const std::string&) {
                         EffectTrial trial;
                         const bool is_seen = request.judges_all_frames && !has_effect(tried, "surface_contact");
                         trial.figures = {figure(Requirement::bone_depth, is_seen ? deep_m : 0, 1e-4)};
                         trial.judged_all_frames = request.judges_all_frames;
                         return trial;
                       },
                       {.judges_the_end = judges_the_end});
    EXPECT_EQ(names_of(choice.added), judges_the_end ? Names{"surface_contact"} : Names{});
  }
}

TEST(EffectSearch, WithoutAShapeNothingIsCalledNeedless) {
  Scene scene = scene_of("[effects.gravity]\n[effects.edge_length]\n[effects.volume]\n");
  const EffectChoice choice =
      choose_effects(scene,
                     [](const Scene&, const TrialRequest&, const std::string&) {
                       EffectTrial trial;
                       trial.figures = {figure(Requirement::whole_surface, std::numeric_limits<double>::infinity(), 3)};
                       return trial;
                     },
                     {.looks_for_needless = true});
  EXPECT_TRUE(choice.needless.empty());
  EXPECT_NE(choice.unmet.front().text().find("the run diverges"), std::string::npos) << choice.unmet.front().text();
}

/// What was tried with few frames judged says nothing of all of them.
TEST(EffectSearch, TheSecondRoundTriesAnew) {
  Scene scene = scene_of("[effects]\nno_passage = false\n[effects.edge_length]\n[effects.volume]\n");
  const EffectChoice choice = choose_effects(
      scene,
      [](const Scene& tried, const TrialRequest& request, const std::string&) {
        EffectTrial trial;
        const bool is_held = has_effect(tried, "surface_contact") && !request.judges_all_frames;
        trial.figures = {figure(Requirement::bone_passage, 9, 0),  // that nothing mends
                         figure(Requirement::bone_depth, request.judges_all_frames && !is_held ? deep_m : 0, 1e-4)};
        trial.judged_all_frames = request.judges_all_frames;
        return trial;
      },
      {.judges_the_end = true});
  EXPECT_TRUE(choice.added.empty());
  EXPECT_EQ(choice.unmet.size(), 2U);
}

/// What only one of two keeps is needed once: both can't go.
TEST(EffectSearch, NeedlessEffectsAreLeftOutTogether) {
  Scene scene = scene_of("[effects.edge_length]\n[effects.volume]\n[effects.local_volume]\n");
  const EffectChoice choice = searched(
      scene,
      [](const Scene& tried) {
        const bool is_kept = has_effect(tried, "volume") || has_effect(tried, "local_volume");
        return std::vector{figure(Requirement::volume, is_kept ? 0 : 0.2, 0.01)};
      },
      true);
  EXPECT_EQ(choice.needless.size(), 2U);  // edge_length and one of the volumes
  EXPECT_TRUE(has_effect(scene, "volume") && has_effect(scene, "local_volume"));
}

/// It did not come to what it would have spoilt.
TEST(EffectSearch, WhatKeepsARunFromDivergingIsTaken) {
  Scene scene = scene_of(whole_ball);
  const EffectChoice choice = searched(scene, [](const Scene& tried) {
    const bool is_whole = has_effect(tried, "self_contact");
    return std::vector{figure(Requirement::whole_surface, is_whole ? 1 : std::numeric_limits<double>::infinity(), 3),
                       figure(Requirement::bone_depth, is_whole ? 2e-4 : 0, 1e-4)};
  });
  EXPECT_EQ(names_of(choice.added), Names{"self_contact"});
}

/// A search takes the place of what rules have added.
TEST(EffectSearch, WhatTheCheckerAddedIsTakenAwayFirst) {
  Scene scene = scene_of(whole_ball);
  add_effect(scene, {"surface_contact"}, "surface_contact", "guessed");
  const EffectChoice choice = searched(
      scene, [](const Scene&) { return std::vector{figure(Requirement::bone_depth, 0, 1e-4)}; }, true);
  EXPECT_FALSE(has_effect(scene, "surface_contact"));
  EXPECT_EQ(choice.needless.size(), 2U);  // of the scene's own
}

/// Its own effects stay; those that change nothing are named.
TEST(EffectSearch, OwnEffectsThatChangeNothingAreNamed) {
  Scene scene = scene_of("[effects.gravity]\n[effects.edge_length]\n[effects.volume]\n[effects.bending]\n");
  const EffectChoice choice = searched(
      scene,
      [](const Scene& tried) {
        return std::vector{figure(Requirement::volume, has_effect(tried, "volume") ? 0 : 0.2, 0.01)};
      },
      true);
  Names named;
  for (const std::string& line : choice.needless) named.push_back(line.substr(0, line.find(':')));
  EXPECT_EQ(named, (Names{"edge_length", "bending"}));  // without gravity the shape moves
  EXPECT_TRUE(has_effect(scene, "bending"));
}

/// An effect that a rule says cannot act is not run: `multi_bone` with one bone.
TEST(EffectSearch, WhatCannotActIsNotRun) {
  SceneRequest request;
  request.name = request.file = "one_bone.toml";
  request.text = std::string("[loop]\nframes = 6\n") + whole_ball + one_ball +
                 "[[bone]]\nname = \"plate\"\nmesh = \"synthetic:plate\"\n";
  request.synthetic_mesh = [](const std::string& name) { return pressed_ball_mesh(name); };
  Scene scene = read_scene(request);
  const EffectChoice choice =
      searched(scene, [](const Scene&) { return std::vector{figure(Requirement::bone_depth, deep_m, 1e-4)}; });
  EXPECT_EQ(std::ranges::count(changes_of(choice), "+ multi_bone"), 0);
  EXPECT_NE(choice.unmet.front().text().find("multi_bone is not run"), std::string::npos)
      << choice.unmet.front().text();
}

TEST(EffectSearch, ASceneThatCannotRunIsToldAndNotSearched) {
  Scene scene = scene_of(whole_ball);
  const EffectChoice choice = choose_effects(scene, [](const Scene&, const TrialRequest&, const std::string&) {
    EffectTrial trial;
    trial.refusal = "no";
    return trial;
  });
  EXPECT_EQ(choice.unmet.front().what, "no");
  EXPECT_TRUE(choice.was_refused);
  EXPECT_EQ(choice.tried.size(), 1U);
}

}  // namespace
}  // namespace musclebench

#include <algorithm>
#include <set>
#include <utility>

#include "core/base/input_error.hpp"
#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/tests/check_fixture.hpp"

namespace musclebench {
namespace {

/// A ball over a plate that turns, with what every muscle wants.
Scene scene_with(const std::string& more, const std::string& of_muscle = "") {
  return check_scene_of(short_loop + bone_text("plate", turning(10)) + muscle_text("ball", of_muscle) +
                        "[effects.edge_length]\nanisotropy_exponent = 0\n" + more);
}

TEST(EffectRules, SayNothingOfASoundScene) {
  EXPECT_TRUE(check_scene(scene_with("[effects.volume]\n"), {.only_quick = true}).empty());
}

TEST(EffectRules, FindWhatAnEffectLeavesOut) {
  const auto told = [](const std::string& effects) {
    std::vector<std::string> texts;
    for (const Finding& finding : check_scene(scene_with("[effects.volume]\n" + effects), {.only_quick = true})) {
      EXPECT_EQ(finding.kind, FindingKind::acts_in_part);
      EXPECT_EQ(finding.id, "partial_effect");
      texts.push_back(text_of(finding));
    }
    return texts;
  };
  const auto texts = told("[effects.margin]\n[effects.self_contact]\n");
  ASSERT_EQ(texts.size(), 1U);
  EXPECT_EQ(texts[0].find("acts in part [partial_effect]: "), 0U) << texts[0];
  EXPECT_NE(texts[0].find("effects.margin"), std::string::npos) << texts[0];
  EXPECT_TRUE(told("[effects.margin]\n[effects.surface_contact]\n").empty());
  EXPECT_TRUE(told("[effects.friction]\n[effects.surface_contact]\n[effects.self_contact]\n").empty());
  EXPECT_TRUE(told("[effects.surface_contact]\n[effects.self_contact]\n").empty());
}

TEST(EffectRules, FindMarginsBetweenMuscles) {
  const std::string two = short_loop + bone_text("plate", turning(10)) + muscle_text("ball") + muscle_text("far") +
                          "[effects.edge_length]\nanisotropy_exponent = 0\n[effects.volume]\n[effects.margin]\n";
  EXPECT_FALSE(is_found(check_scene_of(two), "partial_effect"));
  EXPECT_TRUE(is_found(check_scene_of(two + "[contact]\nmuscle_contact = true\n"), "partial_effect"));
}

/// The plate's attachment reaches up to where the lid is near: 20 mm bind all but the ball's top.
TEST(EffectRules, FindFacesThatAreBoundToAnotherBoneThanTheyTouch) {
  const auto with = [](double distance_m, const std::string& effect) {
    return check_scene_of(short_loop + bone_text("plate", turning(10)) + bone_text("lid") + muscle_text("ball") +
                          attachment_text("plate", "ball", distance_m) + "[effects.attachment]\n" +
                          "[effects.edge_length]\nanisotropy_exponent = 0\n[effects.volume]\n" + effect);
  };
  const std::string effect = "[effects.surface_contact]\n";
  EXPECT_TRUE(is_found(with(0.02, effect), "bound_faces", "bone 'lid'"));
  EXPECT_FALSE(is_found(with(0.02, effect), "bound_faces", "bone 'plate'"));
  EXPECT_FALSE(is_found(with(0.02, ""), "bound_faces"));
  EXPECT_FALSE(is_found(with(0.003, effect), "bound_faces"));
  const std::vector<SceneWarning> warnings = warnings_of(with(0.02, effect));
  EXPECT_TRUE(std::ranges::any_of(warnings, [](const SceneWarning& each) { return each.rule == "bound_faces"; }));
}

TEST(EffectRules, FindParametersThatDoNothing) {
  struct Example {
    std::string effect, parameter, harmless;
  };
  for (const auto& [effect, parameter, harmless] :
       {Example{"damping", "rate_per_s", "1"}, Example{"friction", "coefficient", "0.1"},
        Example{"margin", "thickness_m", "0.001"}, Example{"volume", "projection_scale", "0.1"},
        Example{"local_volume", "projection_scale", "0.1"}, Example{"bending", "stiffness", "0.1"},
        Example{"activation", "level", "0.1"}, Example{"activation", "shortening", "0.1"},
        Example{"fibre_force", "peak_stress_pa", "0.1"}}) {
    const auto text = [&, &name = effect, &key = parameter](const std::string& value) {
      return fmt::format("[effects.{}]\n{} = {}\n", name, key, value);
    };
    const std::string where = fmt::format("effects.{}.{}", effect, parameter);
    const Findings findings = check_scene(scene_with(text("0")), {.only_quick = true});
    const Finding* finding = find_finding(findings, "zero_parameter", where);
    ASSERT_NE(finding, nullptr) << where;
    EXPECT_EQ(finding->kind, FindingKind::cannot_act);
    EXPECT_EQ(finding->remove, std::vector<std::string>{fmt::format("[effects.{}]", effect)});
    EXPECT_FALSE(is_found(scene_with(text(harmless)), "zero_parameter", where));
  }
  EXPECT_TRUE(is_found(scene_with("[effects.gravity]\nz_m_per_s2 = 0\n"), "zero_parameter", "effects.gravity"));
  EXPECT_FALSE(is_found(scene_with("[effects.gravity]\n"), "zero_parameter"));
}

TEST(EffectRules, FindWhatLacksFibres) {
  const std::string activation = "[effects.activation]\n";
  EXPECT_TRUE(is_found(scene_with(activation), "no_fibres", "effects.activation"));
  EXPECT_FALSE(is_found(scene_with(""), "no_fibres"));
  const auto with_exponent = [](const std::string& of_muscle) {
    return check_scene_of(short_loop + bone_text("plate") + bone_text("lid", turning(1)) +
                          muscle_text("ball", of_muscle) + attachment_text("plate", "ball", 0.003) +
                          attachment_text("lid", "ball", 0.003, 0.024) +
                          "[effects.attachment]\n[effects.edge_length]\nanisotropy_exponent = 0.5\n");
  };
  EXPECT_TRUE(is_found(with_exponent(""), "no_fibres", "edge_length.anisotropy_exponent"));
  EXPECT_FALSE(is_found(with_exponent("fibres = \"between_attachments\"\n"), "no_fibres"));
}

TEST(EffectRules, FindFibresThatNothingLooksAt) {
  const std::string text = short_loop + bone_text("plate") + bone_text("lid", turning(1)) +
                           muscle_text("ball", "fibres = \"between_attachments\"\n") +
                           attachment_text("plate", "ball", 0.003) + attachment_text("lid", "ball", 0.003, 0.024) +
                           "[effects.attachment]\n[effects.edge_length]\n";
  EXPECT_TRUE(is_found(check_scene_of(text + "anisotropy_exponent = 0\n"), "ignored_fibres"));
  EXPECT_FALSE(is_found(check_scene_of(text), "ignored_fibres"));
  for (const char* pulls : {"activation", "fibre_force"}) {
    EXPECT_FALSE(is_found(check_scene_of(text + fmt::format("anisotropy_exponent = 0\n[effects.{}]\n", pulls)),
                          "ignored_fibres"));
  }
}

TEST(EffectRules, FindAnActivationAfterTheEnd) {
  for (const char* effect : {"activation", "fibre_force"}) {
    const auto is_late = [&](double start_s) {
      return is_found(scene_with(fmt::format("[effects.{}]\nstart_s = {}\n", effect, start_s)), "late_activation",
                      fmt::format("effects.{}.start_s", effect));
    };
    EXPECT_TRUE(is_late(0.011));  // ten frames of a step of 1 ms
    EXPECT_FALSE(is_late(0.009));
  }
}

TEST(EffectRules, FindFibresWhoseSpeedIsThatOfBonesThatJump) {
  const auto jumps = [](const std::string& parameters, const std::string& motion, int to_deg = 1) {
    return is_found(check_scene_of("[loop]\nframes = 10\nbone_motion = \"" + motion + "\"\n" + bone_text("plate") +
                                   bone_text("lid", turning(to_deg)) + muscle_text("ball") +
                                   "[effects.edge_length]\n[effects.fibre_force]\n" + parameters),
                    "speed_of_jumps", "loop.bone_motion");
  };
  EXPECT_TRUE(jumps("", "per_frame"));
  EXPECT_FALSE(jumps("", "interpolated"));
  EXPECT_FALSE(jumps("level = 0\n", "per_frame"));
  EXPECT_FALSE(jumps("fastest_per_s = 0\n", "per_frame"));
  EXPECT_FALSE(jumps("", "per_frame", 0)) << "no bone turns";
}

/// Twice the level needs steps shorter by the square root of two.
TEST(EffectRules, FindStepsInWhichActiveFibresOvershoot) {
  const auto found = [](double level, double time_step_s) {
    return check_scene_of(
        fmt::format("[loop]\nframes = 10\nbone_motion = \"interpolated\"\ntime_step_s = {}\n"
                    "density_kg_per_m3 = 1060.0\n",
                    time_step_s) +
        bone_text("plate") + bone_text("lid", turning(1)) + muscle_text("ball") +
        attachment_text("plate", "ball", 0.003) + attachment_text("lid", "ball", 0.003, 0.024) +
        fmt::format("[effects.attachment]\n[effects.edge_length]\n[effects.fibre_force]\nlevel = {}\n", level));
  };
  const Findings long_steps = check_scene(found(0.1, 0.01), {.only_quick = true});
  const Finding* finding = find_finding(long_steps, "fibre_steps");
  ASSERT_NE(finding, nullptr);
  const double longest_s = finding->figures.back().value;
  EXPECT_GT(longest_s, 1e-5);
  EXPECT_FALSE(is_found(found(0.1, 0.99 * longest_s), "fibre_steps"));
  EXPECT_TRUE(is_found(found(0.1, 1.01 * longest_s), "fibre_steps"));
  EXPECT_FALSE(is_found(found(0.2, 0.7 * longest_s), "fibre_steps"));
  EXPECT_TRUE(is_found(found(0.2, 0.72 * longest_s), "fibre_steps"));
  EXPECT_FALSE(is_found(found(0, 0.01), "fibre_steps"));
}

TEST(EffectRules, FindFibresWithoutTwoEnds) {
  const auto is_inert = [](const std::string& attachments) {
    return is_found(
        check_scene_of(short_loop + bone_text("plate") + bone_text("lid", turning(1)) + muscle_text("ball", "") +
                       attachments + "[effects.attachment]\n" + "[effects.edge_length]\n[effects.fibre_force]\n"),
        "no_fibre_ends", "effects.fibre_force");
  };
  const std::string one = attachment_text("plate", "ball", 0.003);
  EXPECT_TRUE(is_inert(""));
  EXPECT_TRUE(is_inert(one));
  EXPECT_FALSE(is_inert(one + attachment_text("lid", "ball", 0.003, 0.024)));
}

TEST(EffectRules, FindAttachmentsWithoutTheEffectAndTheEffectWithoutAttachments) {
  EXPECT_TRUE(is_found(scene_with("[effects.attachment]\n"), "attachment", "effects.attachment"));
  const std::string attached = attachment_text("plate", "ball", 0.003);
  const Findings findings = check_scene(scene_with(attached), {.only_quick = true});
  const Finding* lacking = find_finding(findings, "attachment");
  ASSERT_NE(lacking, nullptr);
  EXPECT_EQ(lacking->kind, FindingKind::lacking);
  EXPECT_EQ(lacking->effect->name, "attachment");
  EXPECT_FALSE(is_found(scene_with(attached + "[effects.attachment]\n"), "attachment"));
}

TEST(EffectRules, FindRingsWithoutTheEffectAndTheEffectWithoutRings) {
  const auto scene = [](const std::string& more) {
    return check_scene_of(bone_text("plate", turning(1)) + muscle_text("ball") + more + "[effects.edge_length]\n");
  };
  const std::string ring = ring_text("ball", 0.0101);
  const std::string effect = "[effects.retinaculum]\n";
  EXPECT_TRUE(is_found(scene(ring), "retinaculum"));
  EXPECT_TRUE(is_found(scene(effect), "retinaculum"));
  EXPECT_FALSE(is_found(scene(ring + effect), "retinaculum"));
}

TEST(EffectRules, AskForEdgeLengths) {
  EXPECT_TRUE(is_found(check_scene_of(bone_text("plate", turning(1)) + muscle_text("ball")), "edge_length"));
}

TEST(EffectRules, FindVolumesThatMeanNothing) {
  const auto with_volume = [](const std::string& muscle, const std::string& effect) {
    return check_scene_of(bone_text("plate", turning(1)) + muscle_text(muscle) + "[effects.edge_length]\n" +
                          fmt::format("[effects.{}]\n", effect));
  };
  for (const char* effect : {"volume", "local_volume"}) {
    EXPECT_TRUE(is_found(with_volume("bowl", effect), "open_volume", fmt::format("effects.{}", effect)));
    EXPECT_FALSE(is_found(with_volume("ball", effect), "open_volume"));
  }
  const Findings both = check_scene(scene_with("[effects.volume]\n[effects.local_volume]\n"), {.only_quick = true});
  const Finding* two = find_finding(both, "two_volumes");
  ASSERT_NE(two, nullptr);
  EXPECT_EQ(two->remove, std::vector<std::string>{"[effects.volume]"});
  EXPECT_TRUE(two->add.empty());
  EXPECT_FALSE(is_found(scene_with("[effects.local_volume]\n"), "two_volumes"));
}

TEST(EffectRules, FindParametersThatAnotherOneSwitchesOff) {
  const std::string guard = "[effects.tunnelling_guard]\nangle_deg = 120\n";
  EXPECT_TRUE(is_found(scene_with(guard), "ignored_guard_angle"));
  EXPECT_FALSE(is_found(scene_with(guard + "rule = \"angle\"\n"), "ignored_guard_angle"));
  EXPECT_FALSE(is_found(scene_with("[effects.tunnelling_guard]\n"), "ignored_guard_angle"));
}

TEST(EffectRules, FindSearchesThatNeverComeAgain) {
  const auto every = [](int steps) { return fmt::format("[effects.surface_contact]\ninterval = {}\n", steps); };
  EXPECT_TRUE(is_found(scene_with(every(10)), "late_surface_contact", "effects.surface_contact.interval"));
  EXPECT_FALSE(is_found(scene_with(every(9)), "late_surface_contact"));
}

TEST(EffectRules, FindStepsThatSeveralBonesOverrule) {
  const std::string bones = "[effects.multi_bone]\n" + bone_text("lid");
  EXPECT_TRUE(is_found(scene_with(bones + "[contact]\nsteps = 2\n"), "overruled_steps", "contact.steps"));
  EXPECT_FALSE(is_found(scene_with(bones), "overruled_steps"));
  EXPECT_FALSE(is_found(scene_with("[contact]\nsteps = 2\n"), "overruled_steps"));
}

TEST(EffectRules, FindThatBacktrackingContradictsEffectsThatProject) {
  const std::string backtrack = "[contact]\nresponse = \"backtrack\"\n";
  EXPECT_TRUE(is_found(scene_with("[effects.margin]\n" + backtrack), "backtracking", "effects.margin"));
  EXPECT_FALSE(is_found(scene_with("[effects.margin]\n"), "backtracking"));
  EXPECT_FALSE(is_found(scene_with(backtrack), "backtracking"));
}

TEST(EffectRules, FindThatNoNodeIsFree) {
  const std::string attached = "[effects.attachment]\n" + attachment_text("plate", "ball", 0.05);
  EXPECT_TRUE(is_found(scene_with(attached), "all_bound", "attachment"));
  EXPECT_FALSE(is_found(scene_with("[effects.attachment]\n" + attachment_text("plate", "ball", 0.004)), "all_bound"));
}

TEST(EffectRules, LetActivationHoldASurface) {
  const auto scene = [](const std::string& fibres) {
    return check_scene_of(short_loop + bone_text("plate") + bone_text("lid", turning(1)) + muscle_text("ball", fibres) +
                          attachment_text("plate", "ball", 0.003) + attachment_text("lid", "ball", 0.003, 0.024) +
                          "[effects.attachment]\n[effects.activation]\n");
  };
  EXPECT_FALSE(is_found(scene("fibres = \"between_attachments\"\n"), "edge_length"));
  EXPECT_TRUE(is_found(scene(""), "edge_length"));
}

TEST(EffectRules, TellTheFileAndLine) {
  const Findings findings = check_scene(scene_with("[effects.damping]\nrate_per_s = 0\n"), {.only_quick = true});
  const Finding* zero = find_finding(findings, "zero_parameter");
  ASSERT_NE(zero, nullptr);
  const std::string text = short_loop + bone_text("plate", turning(10)) + muscle_text("ball") +
                           "[effects.edge_length]\nanisotropy_exponent = 0\n";
  EXPECT_EQ(zero->place, fmt::format("test.toml:{}", std::ranges::count(text, '\n') + 1));
  EXPECT_NE(text_of(*zero).find("test.toml:"), std::string::npos);
}

TEST(EffectRules, FindFibresOfAnotherMuscle) {
  const auto finds = [](const Vec3& at, double length_m) {
    Scene scene = scene_with("");
    scene.muscles[0].fibres = {{at, at + Vec3(length_m, 0, 0)}, {at, at + Vec3(0, length_m, 0)}};
    const Findings findings = check_scene(scene, {.only_quick = true});
    const Finding* found = find_finding(findings, "foreign_fibres", "muscle 'ball'");
    return found == nullptr ? std::string() : found->what;
  };
  EXPECT_EQ(finds(Vec3(0, 0, 0.0125), 0.001), "");
  EXPECT_TRUE(finds(Vec3(0.1, 0, 0), 0.001).starts_with("100 % of their segments lie outside"));
  EXPECT_TRUE(finds(Vec3(0, 0, 0.0125), 0).starts_with("100 % of their segments have no length"));
}

TEST(ReadEffects, NamesOfTheLiteratureAreShownTheirPlace) {
  for (const auto& [name, place] : {std::pair{"muscle_contact", "[contact]"},
                                    {"contact", "--backend"},
                                    {"fibre_anisotropy", "anisotropy_exponent"}}) {
    try {
      (void)scene_with(fmt::format("[effects.{}]\n", name));
      ADD_FAILURE() << name;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(place), std::string::npos) << error.what();
    }
  }
}

TEST(EffectRules, FindSeveralBonesOfOne) {
  EXPECT_TRUE(is_found(scene_with("[effects.multi_bone]\n"), "one_bone"));
  EXPECT_FALSE(is_found(scene_with("[effects.multi_bone]\n" + bone_text("lid")), "one_bone"));
}

TEST(EffectRules, FindAStandstill) {
  const auto still = [](const std::string& motion, const std::string& effects) {
    return is_found(
        check_scene_of(bone_text("plate", motion) + muscle_text("ball") + "[effects.edge_length]\n" + effects),
        "standstill");
  };
  EXPECT_TRUE(still("", ""));
  EXPECT_TRUE(still(turning(0), ""));
  EXPECT_FALSE(still(turning(1), ""));
  EXPECT_FALSE(still("", "[effects.gravity]\n"));
  EXPECT_FALSE(still("", "[effects.activation]\n"));
  EXPECT_TRUE(still("", "[effects.volume]\n"));
  EXPECT_FALSE(still("", "[effects.volume]\npressure = 1.1\n"));
  EXPECT_FALSE(is_found(check_scene_of(bone_text("plate", "") + muscle_text("ball") +
                                       "velocity_m_per_s = [0, 0, 1]\n[effects.edge_length]\n"),
                        "standstill"));
}

TEST(EffectRules, FindExclusionsOfNothing) {
  EXPECT_TRUE(is_found(scene_with("[effects]\nfriction = false\n"), "idle_exclusion", "effects.friction"));
  EXPECT_FALSE(is_found(scene_with("[effects]\nauto = true\nfriction = false\n"), "idle_exclusion"));
  SceneRequest request;
  request.name = request.file = "test.toml";
  request.text = "preset = \"any\"\n" + bone_text("plate") + muscle_text("ball") + "[effects]\nfriction = false\n";
  request.synthetic_mesh = check_mesh_named;
  request.preset_text = [](const std::string& /*name*/) { return "[effects.friction]\n"; };
  EXPECT_FALSE(is_found(read_scene(request), "idle_exclusion"));
}

TEST(EffectRules, FindAttachmentsWhoseNodesAreClaimed) {
  const std::string once = attachment_text("plate", "ball", 0.003);
  EXPECT_FALSE(is_found(scene_with(once), "claimed_attachment"));
  EXPECT_FALSE(is_found(scene_with(once + attachment_text("plate", "ball", 0.004)), "claimed_attachment"));
  EXPECT_TRUE(is_found(scene_with(once + once), "claimed_attachment", "attachment 'on_plate'"));
}

TEST(SceneRules, HaveIdsOfTheirOwn) {
  std::set<std::string> ids;
  for (const SceneRule& rule : general_rules()) ids.insert(rule.id);
  EXPECT_EQ(ids.size(), general_rules().size());
  for (const EffectChecksSource& source : effect_checks_table()) {
    std::set<std::string> own;
    for (const SceneRule& rule : find_checks(source.effect)->rules) own.insert(rule.id);
    EXPECT_EQ(own.size(), find_checks(source.effect)->rules.size()) << source.effect;
  }
}

TEST(SceneRules, FindingsAreOneLineEach) {
  const Scene scene = check_scene_of(bone_text("plate") + muscle_text("ball") + muscle_text("other") +
                                     "[effects.multi_bone]\n[effects.damping]\nrate_per_s = 0\n");
  const Findings findings = check_scene(scene);
  EXPECT_GE(findings.size(), 5U);
  for (const Finding& finding : findings) {
    const std::string line = text_of(finding);
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    EXPECT_NE(line.find(fmt::format("[{}]: {}: {}: ", finding.id, finding.place, finding.where)), std::string::npos)
        << line;
    for (const std::string& words : finding.add) EXPECT_NE(line.find(words), std::string::npos) << line;
    for (const std::string& words : finding.remove) EXPECT_NE(line.find(words), std::string::npos) << line;
  }
}

}  // namespace
}  // namespace musclebench

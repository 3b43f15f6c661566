#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/base/temporary_folder.hpp"
#include "core/mesh/shapes.hpp"
#include "core/scene/read_scene.hpp"
#include "core/scene/scene_warnings.hpp"
#include "core/scene/tests/scene_errors.hpp"

namespace musclebench {
namespace {

constexpr const char* bones_and_muscle = R"(
[[bone]]
name = "box"
mesh = "synthetic:box"
[bone.motion]
axis = [0, 0, 2]
centre_m = [0, 0, 0]
from_deg = 0
to_deg = 90

[muscle]
name = "ball"
mesh = "synthetic:ball"
)";

SceneRequest request_of(const std::string& text) {
  SceneRequest request;
  request.name = "test";
  request.file = "test.toml";
  request.text = text;
  request.preset_text = [](const std::string& name) -> std::string {
    if (name != "soft") {
      throw InputError("preset", "unknown");
    }
    return "[loop]\nframes = 10\nsubsteps = 4\n[effects.edge_length]\nstiffness = 0.5\n[effects.gravity]\n";
  };
  request.synthetic_mesh = [](const std::string& name) {
    TriangleMesh mesh = name == "box" ? make_box(Vec3(0.02, 0.03, 0.01), 4) : make_sphere(0.01, 2);
    if (name == "ball") {
      for (Vec3& x : mesh.vertices) {
        x += Vec3(0, 0, 0.021);
      }
    }
    return mesh;
  };
  return request;
}

std::string error_of(const std::string& text) { return error_of(request_of(text)); }

void expect_one_line(const std::string& message, const std::vector<std::string>& words) {
  expect_mentions(message, words);
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

TEST(ReadScene, SceneOverwritesItsPreset) {
  const Scene scene = read_scene(request_of(std::string("preset = \"soft\"\n") + bones_and_muscle +
                                            "[loop]\nframes = 7\n[effects.edge_length]\nvisits_per_edge = 2\n"));
  EXPECT_EQ(scene.loop.frames, 7);
  EXPECT_EQ(scene.loop.substeps, 4);
  ASSERT_EQ(scene.effects.size(), 2U);
  EXPECT_EQ(scene.effects[0].name, "gravity");
  EXPECT_EQ(scene.effects[1].parameters.number("stiffness"), 0.5);
  EXPECT_EQ(scene.effects[1].parameters.integer("visits_per_edge"), 2);
}

TEST(ReadScene, BonesAreNumberedCoherentlyWhateverOrderAFileHas) {
  SceneRequest stirred = request_of(std::string("preset = \"soft\"\n") + bones_and_muscle);
  stirred.synthetic_mesh = [read = stirred.synthetic_mesh](const std::string& name) {
    TriangleMesh mesh = read(name);
    std::vector<Triangle> triangles;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {  // 101 and their number have no common divisor
      triangles.push_back(mesh.triangles[101 * i % mesh.triangles.size()]);
    }
    mesh.triangles = triangles;
    return mesh;
  };
  const Scene scene = read_scene(stirred);
  const TriangleMesh& mesh = scene.bones[0].surface.mesh;
  double way_m = 0;
  for (std::size_t i = 1; i < mesh.triangles.size(); ++i) {
    way_m += (mesh.vertices[mesh.triangles[i][0]] - mesh.vertices[mesh.triangles[i - 1][0]]).norm();
  }
  const double largest_side_m = 0.06;
  EXPECT_LT(way_m, 0.4 * largest_side_m * static_cast<double>(mesh.triangles.size()));
}

TEST(ReadScene, AnEffectThatTheSceneTakesAwayDoesNotExist) {
  const Scene scene =
      read_scene(request_of(std::string("preset = \"soft\"\n") + bones_and_muscle + "[effects]\ngravity = false\n"));
  ASSERT_EQ(scene.effects.size(), 1U);
  EXPECT_EQ(scene.effects[0].name, "edge_length");
}

TEST(ReadScene, TheMotionGoesThereAndBack) {
  Scene scene = read_scene(request_of(std::string("preset = \"soft\"\n") + bones_and_muscle));
  EXPECT_NEAR(scene.angle_rad(0), 0, 1e-15);
  EXPECT_NEAR(scene.angle_rad(5), std::numbers::pi / 2, 1e-15);
  EXPECT_NEAR(scene.angle_rad(2.5), std::numbers::pi / 4, 1e-15);
  EXPECT_NEAR(scene.angle_rad(10), 0, 1e-15);
  scene.loop.frames = 14;
  scene.loop.rest_frames = 4;
  EXPECT_NEAR(scene.angle_rad(2.5), std::numbers::pi / 4, 1e-15);
  EXPECT_NEAR(scene.angle_rad(5), std::numbers::pi / 2, 1e-15);
  for (const double at_rest : {10.0, 11.5, 14.0}) EXPECT_NEAR(scene.angle_rad(at_rest), 0, 1e-15);
  std::vector<RigidMotion> poses;
  scene.poses_at(5, poses);
  EXPECT_LT((poses[0].apply(Vec3(1, 0, 0)) - Vec3(0, 1, 0)).norm(), 1e-15);
}

TEST(ReadScene, MeshesAreSplitAsOftenAsSceneOrRequestSay) {
  const std::string text = std::string("preset = \"soft\"\n") + bones_and_muscle;
  const Scene plain = read_scene(request_of(text));
  SceneRequest request = request_of(text + "[meshes]\nsplit_muscles = 1\nsmooth_bones = 1\n");
  request.mesh_overrides = {{"split_muscles", std::int64_t{2}}};
  const Scene fine = read_scene(request);
  EXPECT_EQ(fine.mesh_splits.split_muscles, 2);
  EXPECT_EQ(fine.mesh_splits.smooth_bones, 1);
  EXPECT_EQ(fine.muscle_mesh.triangles.size(), 16 * plain.muscle_mesh.triangles.size());
  EXPECT_TRUE(std::equal(plain.muscle_mesh.vertices.begin(), plain.muscle_mesh.vertices.end(),
                         fine.muscle_mesh.vertices.begin()));
  EXPECT_EQ(fine.muscles[0].file.mesh.triangles.size(), fine.muscle_mesh.triangles.size());
  EXPECT_EQ(fine.muscles[0].file.sha256, plain.muscles[0].file.sha256);
  EXPECT_EQ(fine.bones[0].surface.mesh.triangles.size(), 4 * plain.bones[0].surface.mesh.triangles.size());
  EXPECT_EQ(fine.bones[0].surface.clean, plain.bones[0].surface.clean);
  EXPECT_EQ(fine.bone_meshes[0].mesh.vertices, plain.bone_meshes[0].mesh.vertices);
  expect_one_line(error_of(text + "[meshes]\nsplit = 1\n"), {"test.toml:", "split", "did you mean 'split_muscles'?"});
  expect_one_line(error_of(text + "[meshes]\nsplit_muscles = 9\n"), {"test.toml:", "split_muscles"});
}

TEST(ReadScene, MoreTrianglesThanFitAreRefused) {
  SceneRequest request = request_of(std::string("preset = \"soft\"\n") + bones_and_muscle);
  request.synthetic_mesh = [](const std::string& name) {
    return name == "box" ? make_box(Vec3(0.02, 0.03, 0.01), 4) : make_sphere(0.01, 6);
  };
  request.mesh_overrides = {{"split_muscles", std::int64_t{4}}};
  expect_one_line(error_of(request), {"test.toml:", "ball", "20971520 triangles after [meshes]", "less often"});
}

constexpr const char* box_without_motion = "[[bone]]\nname = \"box\"\nmesh = \"synthetic:box\"\n";
constexpr const char* ball = "[muscle]\nname = \"ball\"\nmesh = \"synthetic:ball\"\n";

/// The second axis is carried along by the first rotation, as in OpenSim's joints: z by 90 degrees, then the x axis of
/// the bone, which points along y by then.
TEST(ReadScene, EachRotationCarriesTheAxesOfThoseAfterIt) {
  const auto rotation = [](const char* axis) {
    return std::string(
               "[[bone.motion]]\ncentre_m = [0, 0, 0]\nfrom_deg = 0\nto_deg = 90\ncourse = \"there\"\naxis = ") +
           axis + "\n";
  };
  const std::string text =
      std::string("[loop]\nframes = 10\n") + box_without_motion + rotation("[0, 0, 1]") + rotation("[1, 0, 0]") + ball;
  const Scene scene = read_scene(request_of(text));
  std::vector<RigidMotion> poses;
  scene.poses_at(10, poses);
  EXPECT_LT((poses[0].apply(Vec3(1, 0, 0)) - Vec3(0, 1, 0)).norm(), 1e-15);
  EXPECT_LT((poses[0].apply(Vec3(0, 1, 0)) - Vec3(0, 0, 1)).norm(), 1e-15);
  EXPECT_NEAR(scene.angle_rad(5), std::numbers::pi / 4, 1e-15);

  SceneRequest overridden = request_of(text);
  overridden.motion_overrides = {{"to_deg", 10.0}};
  expect_one_line(error_of(overridden), {"--motion", "bone", "several rotations"});
  expect_one_line(error_of(text + "[measure]\nfibres = 10\n"), {"test.toml:", "fibres", "'box'", "several"});
}

TEST(ReadScene, AMotionMayGoToItsFirstAngleFromRest) {
  const auto angles_deg = [](const std::string& from, const std::string& to, const std::string& course = "rest_first") {
    const Scene scene = read_scene(request_of("[loop]\nframes = 12\n" + std::string(box_without_motion) +
                                              "[bone.motion]\ncentre_m = [0, 0, 0]\naxis = [0, 0, 1]\ncourse = \"" +
                                              course + "\"\nfrom_deg = " + from + "\nto_deg = " + to + "\n" + ball));
    std::vector<double> angles;
    for (const int frame : {0, 1, 2, 4, 12}) angles.push_back(scene.angle_rad(frame) * degrees_per_radian);
    return angles;
  };
  const auto expect_near = [](const std::vector<double>& found, const std::vector<double>& wanted) {
    for (std::size_t i = 0; i < wanted.size(); ++i) EXPECT_NEAR(found[i], wanted[i], 1e-12) << i;
  };
  expect_near(angles_deg("-20", "80"), {0, -10, -20, 0, 80});
  expect_near(angles_deg("0", "60"), {0, 5, 10, 20, 60});
  expect_near(angles_deg("30", "30"), {0, 2.5, 5, 10, 30});
  expect_near(angles_deg("-20", "40", "rest_to_rest"), {0, -10, -20, 0, 0});
  expect_near(angles_deg("0", "60", "rest_to_rest"), {0, 10, 20, 40, 0});
  expect_near(angles_deg("0", "0", "rest_to_rest"), {0, 0, 0, 0, 0});
  expect_one_line(error_of(std::string(box_without_motion) +
                           "[bone.motion]\ncentre_m = [0, 0, 0]\naxis = [0, 0, 1]\ncourse = \"rest_first\"\n"
                           "table = \"no.mot\"\ncolumn = \"hip\"\n" +
                           ball),
                  {"test.toml:", "rest_first", "table of angles"});
}

/// A muscle that comes from two bones: its fibres do not run from one of them to the other.
TEST(ReadScene, AMuscleMayComeFromSeveralBones) {
  const auto attachment = [](const std::string& bone, const std::string& point_m, const std::string& end) {
    return fmt::format(
        "[[attachment]]\nname = \"{0}\"\nbone = \"{0}\"\nnear = \"points\"\noutline_m = [{1}]\n"
        "distance_m = 0.004\n{2}",
        bone, point_m, end.empty() ? "" : "end = \"" + end + "\"\n");
  };
  const auto scene_of = [&](const std::string& box, const std::string& knob, const std::string& cap) {
    const auto bone = [](const std::string& name) {
      return "[[bone]]\nname = \"" + name + "\"\nmesh = \"synthetic:" + name + "\"\n";
    };
    return request_of(std::string(box_without_motion) + bone("knob") + bone("cap") + ball +
                      attachment("box", "[0, 0, 0.011]", box) + attachment("knob", "[0.01, 0, 0.021]", knob) +
                      attachment("cap", "[0, 0, 0.031]", cap));
  };
  const auto origins = [](const SceneRequest& request) {
    const Scene scene = read_scene(request);
    return scene.end_nodes(0, scene.bound_nodes()).origin.size();
  };
  const std::size_t of_one = origins(scene_of("", "", ""));
  EXPECT_GT(of_one, 0U);
  EXPECT_GT(origins(scene_of("origin", "origin", "insertion")), of_one);
  EXPECT_EQ(origins(scene_of("origin", "insertion", "insertion")), of_one);
  EXPECT_EQ(origins(scene_of("insertion", "insertion", "origin")), of_one);
  expect_one_line(error_of(scene_of("insertion", "", "")), {"end", "no attachment of this muscle", "origin"});
  expect_one_line(error_of(scene_of("begin", "", "")), {"end", "'begin' has to be origin or insertion"});
}

/// As the bones of a foot at the ankle.
TEST(ReadScene, BonesThatTurnAsOneHaveOneAxisForMomentArms) {
  const auto error_with = [](const std::string& other_deg) {
    const auto motion = [](const std::string& degrees) {
      return "[bone.motion]\ncentre_m = [0, 0, 0]\naxis = [0, 0, 1]\nfrom_deg = 0\nto_deg = " + degrees + "\n";
    };
    return error_of(std::string(box_without_motion) + motion("40") +
                    "[[bone]]\nname = \"knob\"\nmesh = \"synthetic:knob\"\n" + motion(other_deg) + ball +
                    "[measure]\nfibres = 10\n");
  };
  EXPECT_EQ(error_with("40").find("one axis"), std::string::npos) << error_with("40");
  expect_one_line(error_with("30"), {"needs one axis", "'box' and 'knob' turn in different ways"});
}

TEST(ReadScene, AMuscleHasADensityAVelocityAndAnActivationOfItsOwn) {
  const Scene scene = read_scene(request_of(std::string(box_without_motion) + ball +
                                            "density_kg_per_m3 = 500.0\nvelocity_m_per_s = [0, 0, -3]\n"
                                            "activation = 0.25\n"));
  EXPECT_EQ(scene.muscles.front().density_kg_per_m3, 500.0);
  EXPECT_EQ(scene.muscles.front().velocity_m_per_s, Vec3(0, 0, -3));
  EXPECT_EQ(scene.bodies().front().activation, 0.25);
  expect_one_line(error_of(std::string(box_without_motion) + ball + "activation = 1.5\n"),
                  {"activation", "from 0 to 1"});
  expect_one_line(error_of(std::string(box_without_motion) + ball + "velocity_m_per_s = [0, 0, -1e7]\n"),
                  {"velocity_m_per_s", "1e+06 m/s"});
  expect_one_line(error_of(std::string(box_without_motion) + ball + "density_kg_per_m3 = 0\n"), {"density_kg_per_m3"});
}

TEST(ReadScene, TheTimeStepMayChangeDuringTheRun) {
  const auto with = [](const std::string& tables) {
    return std::string("[loop]\nframes = 9\nsubsteps = 2\ntime_step_s = 1.0\n") + box_without_motion + ball + tables;
  };
  const std::string coarse = "[[time_step_change]]\nfrom_frame = 3\ntime_step_s = 10.0\n";
  const LoopParameters loop =
      read_scene(request_of(with(coarse + "[[time_step_change]]\nfrom_frame = 5\ntime_step_s = 1.0\n"))).loop;
  EXPECT_EQ(loop.time_step_of_s(2), 1);
  EXPECT_EQ(loop.time_step_of_s(3), 10);
  EXPECT_EQ(loop.time_step_of_s(5), 1);
  EXPECT_EQ(loop.time_s(2, 2), 4);
  EXPECT_EQ(loop.time_s(3, 1), 14);
  EXPECT_EQ(loop.time_s(4, 2), 44);
  EXPECT_EQ(loop.time_s(6, 1), 47);
  const std::vector<SceneWarning> late =
      scene_warnings(read_scene(request_of(with("[[time_step_change]]\nfrom_frame = 10\ntime_step_s = 2.0\n"))));
  EXPECT_TRUE(
      std::ranges::any_of(late, [](const SceneWarning& warning) { return warning.text.find("frame 10 on") < 99; }));
  expect_one_line(error_of(with(coarse + coarse)), {"test.toml:", "from_frame", "after 3"});
  expect_one_line(error_of(with("[[time_step_change]]\nfrom_frame = 2.5\ntime_step_s = 1.0\n")), {"whole number"});
  expect_one_line(error_of(with("[[time_step_change]]\nfrom_frame = 2\n")), {"time_step_s", "missing"});
}

TEST(ReadScene, NamesFileLineKeyAndNearestKnownKey) {
  expect_one_line(error_of(std::string(bones_and_muscle) + "[loop]\nframse = 3\n"), {"test.toml:", "frames", "framse"});
  expect_one_line(error_of(std::string(bones_and_muscle) + "[effects.bendin]\n"), {"test.toml:", "bendin", "bending"});
  expect_one_line(error_of(std::string(bones_and_muscle) + "[effects.volume]\npresure = 1\n"),
                  {"test.toml:", "effects.volume", "presure", "pressure"});
  expect_one_line(error_of(std::string("titel = \"x\"\n") + bones_and_muscle), {"test.toml:1", "titel", "title"});
  expect_one_line(error_of("[[bone]]\nname = \"b\"\nmesh = \"synthetic:box\"\n[bone.motion]\naxes = [1, 0, 0]\n"),
                  {"test.toml:5", "axes", "axis"});
}

TEST(ReadScene, RefusesValuesOutOfRangeAndOfTheWrongKind) {
  expect_one_line(error_of(std::string(bones_and_muscle) + "[loop]\nframes = 0\n"), {"frames", "0", "1"});
  expect_one_line(error_of(std::string(bones_and_muscle) + "[loop]\ntime_step_s = nan\n"), {"time_step_s", "nan"});
  expect_one_line(error_of(std::string(bones_and_muscle) + "[loop]\nsubsteps = \"many\"\n"),
                  {"substeps", "whole number"});
  expect_one_line(error_of(std::string(bones_and_muscle) + "[loop]\ndamping_per_s = 3\n"),
                  {"test.toml:", "damping_per_s", "[effects.damping]", "rate_per_s"});
  expect_one_line(error_of(std::string(bones_and_muscle) + "[loop]\nbone_motion = \"jumpy\"\n"),
                  {"bone_motion", "jumpy", "per_frame"});
  expect_one_line(error_of("[[bone]]\nname = \"b\"\nmesh = \"synthetic:box\"\n[bone.motion]\naxis = [0, 0, 0]\n"
                           "centre_m = [0, 0, 0]\nfrom_deg = 0\nto_deg = 1\n"),
                  {"axis", "no length"});
  expect_one_line(error_of("[[bone]]\nname = \"b\"\nmesh = \"synthetic:box\"\n[bone.motion]\naxis = [0, inf, 0]\n"),
                  {"axis", "finite"});
}

TEST(ReadScene, RefusesEffectsThatContradictEachOther) {
  const std::string text = std::string(bones_and_muscle) + "[effects.volume]\n";
  expect_one_line(error_of(text + "[effects.local_volume]\npressure = 1.2\n"),
                  {"test.toml:", "effects.local_volume", "1.2", "'volume' 1", "volume = false"});
  EXPECT_EQ(read_scene(request_of(text + "[effects.local_volume]\n")).effects.size(), 2U);
}

TEST(ReadScene, RefusesWhatIsMissingOrTwice) {
  expect_one_line(error_of("title = \"empty\"\n"), {"bone", "missing"});
  expect_one_line(error_of("[[bone]]\nname = \"b\"\nmesh = \"synthetic:box\"\n"), {"muscle", "missing"});
  expect_one_line(error_of("[[bone]]\nname = \"b\"\n"), {"mesh", "missing"});
  expect_one_line(error_of("this is not TOML"), {"test.toml:1", "TOML"});
  expect_one_line(error_of("preset = \"hard\"\n"), {"preset"});
  expect_one_line(error_of("[[bone]]\nname = \"b\"\nmesh = \"synthetic:box\"\n[[bone]]\nname = \"b\"\n"
                           "mesh = \"synthetic:box\"\n"),
                  {"earlier bone"});
  expect_one_line(error_of("[[bone]]\nname = \"b\"\nmesh = \"${data}/x.ply\"\n"), {"--data", "MUSCLEBENCH_DATA"});
  expect_one_line(error_of("[[bone]]\nname = \"b\"\nmesh = \"no/such/file.ply\"\n"), {"test.toml:3", "file.ply"});
}

TEST(ReadScene, AttachmentsBindTheNodesOverTheirArea) {
  const std::string area = R"(
[[attachment]]
name = "foot"
bone = "box"
outline_m = [[-0.02, -0.03, 0.01], [0.02, -0.03, 0.01], [0.02, 0.03, 0.01], [-0.02, 0.03, 0.01]]
distance_m = 0.004
)";
  const Scene scene = read_scene(request_of(std::string(bones_and_muscle) + area));
  const auto& vertices = scene.muscle_mesh.vertices;
  std::vector<int> expected;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (vertices[i].z() - 0.01 <= 0.004) {
      expected.push_back(static_cast<int>(i));
    }
  }
  EXPECT_GT(expected.size(), 5U);
  EXPECT_EQ(scene.attachments.front().nodes, expected);
  expect_one_line(error_of(std::string(bones_and_muscle) + "[[attachment]]\nname = \"a\"\nbone = \"bx\"\n"),
                  {"bx", "box"});
  expect_one_line(error_of(std::string(bones_and_muscle) +
                           "[[attachment]]\nname = \"a\"\nbone = \"box\"\noutline_m = [[0,0,0]]\ndistance_m = 1\n"),
                  {"three points"});
}

TEST(ReadScene, FirstContactNeedsNoAreas) {
  const Scene scene = read_scene(request_of("attachment = \"first_contact\"\n" + std::string(bones_and_muscle)));
  EXPECT_TRUE(scene.attach_at_first_contact);
  expect_one_line(error_of("attachment = \"glue\"\n" + std::string(bones_and_muscle)), {"first_contact"});
}

TEST(Fibres, FollowTheMuscleFromOriginToInsertion) {
  // A bent tube: its fibres have to turn with it, which straight lines between its ends would not.
  TriangleMesh tube = make_capsule(0.01, 0.05, 24);
  std::vector<BoundNode> bound;
  for (std::size_t i = 0; i < tube.vertices.size(); ++i) {
    Vec3& x = tube.vertices[i];
    if (std::abs(x.z()) > 0.05) {
      bound.push_back({static_cast<int>(i), x.z() < 0 ? 0 : 1});
    }
    const double angle = x.z() / 0.06;
    x = Vec3((0.06 + x.x()) * std::cos(angle), x.y(), (0.06 + x.x()) * std::sin(angle));
  }
  Scene scene;
  scene.add_muscle("tube", tube).fibres_between_attachments = true;
  const std::vector<FibreSegment> fibres = scene.fibres_with(bound).at(0);
  ASSERT_GT(fibres.size(), 100U);
  double worst = 1;
  for (const FibreSegment& fibre : fibres) {
    const Vec3 centre = 0.5 * (fibre.start + fibre.end);
    const Vec3 along = Vec3(-centre.z(), 0, centre.x()).normalized();
    worst = std::min(worst, along.dot((fibre.end - fibre.start).normalized()));
  }
  EXPECT_GT(worst, 0.8);
  EXPECT_TRUE(scene.fibres_with({}).at(0).empty());
}

class MotionTableFile : public testing::Test {
 protected:
  std::string write(const std::string& text) {
    const auto path = m_folder / "motion.mot";
    std::ofstream(path) << text;
    return path.string();
  }
  std::string error_of_table(const std::string& text) {
    try {
      (void)read_motion_table(write(text), "hip");
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

 private:
  TemporaryFolder m_folder;
};

TEST_F(MotionTableFile, ReadsAColumnWhateverTheHeaderAnnounces) {
  const MotionTable table = read_motion_table(
      write("name\nnRows=3\nnColumns=3\nendheader\ntime\tknee\thip\n0\t1\t-10\n0.5\t2\t0\n1\t3\t20\n"), "hip");
  EXPECT_EQ(table.times, (std::vector<double>{0, 0.5, 1}));
  EXPECT_EQ(table.values, (std::vector<double>{-10, 0, 20}));
  BoneRotation motion{Vec3::UnitX(), Vec3::Zero(), table.times, table.values, false};
  EXPECT_NEAR(motion.angle_rad(0.25), -5, 1e-15);
  EXPECT_NEAR(motion.angle_rad(1), 20, 1e-15);
  EXPECT_NEAR(motion.angle_rad(0), -10, 1e-15);
}

TEST_F(MotionTableFile, RadiansBecomeDegrees) {
  const MotionTable table = read_motion_table(write("inDegrees=no\nendheader\ntime\thip\n0 0\n1 1.5\n"), "hip");
  EXPECT_NEAR(table.values[1], 1.5 * 180 / std::numbers::pi, 1e-12);
}

TEST_F(MotionTableFile, RefusesDamage) {
  expect_one_line(error_of_table("endheader\ntime\thipp\n0 1\n1 2\n"), {":2", "hipp"});
  expect_one_line(error_of_table("endheader\ntime\thip\n0 1\n1 nan\n"), {":4", "nan"});
  expect_one_line(error_of_table("endheader\ntime\thip\n0 1\n0 2\n"), {":4", "ascend"});
  // The angle between them would be no number.
  expect_one_line(error_of_table("endheader\ntime\thip\n-1e308 1\n1e308 2\n"), {":3", "-1e308", "beyond"});
  expect_one_line(error_of_table("inDegrees=no\nendheader\ntime\thip\n0 1\n1 1e308\n"), {":5", "1e308", "beyond"});
  expect_one_line(error_of_table("endheader\ntime\thip\n0 1\n1\n"), {":4", "values"});
  expect_one_line(error_of_table("endheader\ntime\thip\n0 1\n"), {"two rows"});
  for (const std::string rows : {"nRows=3", "nRows = 3", "datarows 3"}) {
    expect_one_line(error_of_table(rows + "\nendheader\ntime\thip\n0 1\n1 2\n"), {"tells 3 rows", "has 2", "cut"});
  }
  expect_one_line(error_of_table("nColumns=3\nendheader\ntime\thip\n0 1\n1 2\n"), {"tells 3 columns", "has 2"});
  expect_one_line(error_of_table(""), {"two rows"});
}

}  // namespace
}  // namespace musclebench

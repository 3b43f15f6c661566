// Scenes of meshes that nobody here made: what is odd about them is told, and formats don't matter.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sys/stat.h>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/base/temporary_folder.hpp"
#include "core/mesh/mesh_edges.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/surface_volume.hpp"
#include "core/scene/read_scene.hpp"
#include "core/scene/rest_overlap.hpp"
#include "core/scene/scene_warnings.hpp"
#include "core/scene/tests/scene_errors.hpp"

namespace musclebench {
namespace {

constexpr const char* bone_text = R"(
[[bone]]
name = "box"
mesh = "synthetic:box"
)";
constexpr const char* motion_text = R"(
[bone.motion]
axis = [0, 0, 1]
centre_m = [0, 0, 0]
from_deg = 0
to_deg = 90
)";
constexpr const char* muscle_text = R"(
[muscle]
name = "ball"
mesh = "synthetic:ball"
)";
constexpr const char* area_text = R"(
[[attachment]]
name = "{}"
bone = "{}"
outline_m = [[-0.02, -0.03, 0.01], [0.02, -0.03, 0.01], [0.02, 0.03, 0.01], [-0.02, 0.03, 0.01]]
distance_m = {}
)";

std::string attachment(const std::string& name, const std::string& bone, double distance_m) {
  return fmt::format(fmt::runtime(area_text), name, bone, distance_m);
}

TriangleMesh moved(TriangleMesh mesh, const Vec3& by) {
  for (Vec3& vertex : mesh.vertices) {
    vertex += by;
  }
  return mesh;
}

TriangleMesh scaled(TriangleMesh mesh, double factor) {
  for (Vec3& vertex : mesh.vertices) {
    vertex *= factor;
  }
  return mesh;
}

void append(const TriangleMesh& other, TriangleMesh& mesh) {
  const int first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Triangle& triangle : other.triangles) {
    mesh.triangles.push_back({first + triangle[0], first + triangle[1], first + triangle[2]});
  }
}

const Vec3 above(0, 0, 0.021);

struct Meshes {
  TriangleMesh box = make_box(Vec3(0.02, 0.03, 0.01), 4);
  TriangleMesh ball = moved(make_sphere(0.01, 3), above);
};

SceneRequest request(const std::string& text, const Meshes& meshes = {}) {
  SceneRequest request;
  request.name = "test";
  request.file = "test.toml";
  request.text = text;
  request.preset_text = [](const std::string&) { return std::string("[effects.edge_length]\n"); };
  request.synthetic_mesh = [meshes](const std::string& name) { return name == "ball" ? meshes.ball : meshes.box; };
  return request;
}

Scene scene_of(const std::string& text, const Meshes& meshes = {}) { return read_scene(request(text, meshes)); }

std::string plain_text() { return std::string("preset = \"p\"\n") + bone_text + motion_text + muscle_text; }

std::string warnings_of(const Scene& scene) {
  std::string all;
  for (const SceneWarning& warning : scene_warnings(scene)) {
    EXPECT_EQ(warning.text.find('\n'), std::string::npos);
    EXPECT_FALSE(warning.rule.empty());
    all += warning.text + "\n";
  }
  return all;
}

TEST(ForeignScene, NothingIsSaidOfASoundOne) { EXPECT_EQ(warnings_of(scene_of(plain_text())), ""); }

/// As STL has it: three vertices of its own for every triangle.
TriangleMesh soup_of(const TriangleMesh& mesh) {
  TriangleMesh soup;
  for (const auto& [a, b, c] : mesh.triangles) {
    const int first = static_cast<int>(soup.vertices.size());
    soup.vertices.insert(soup.vertices.end(), {mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

/// As OBJ files with seams have it: one half of the surface has vertices of its own.
TriangleMesh with_seam(const TriangleMesh& mesh) {
  TriangleMesh torn = mesh;
  const int count = static_cast<int>(mesh.vertices.size());
  torn.vertices.insert(torn.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
  for (std::size_t t = 0; t < torn.triangles.size() / 2; ++t) {
    for (int& vertex : torn.triangles[t]) {
      vertex += count;
    }
  }
  return torn;
}

TEST(ForeignScene, AMuscleIsTheSameWhateverItsFormat) {
  Meshes meshes;
  meshes.ball = moved(make_sphere(0.01, 3), Vec3(0, 0, 0.018));  // 2 mm deep in the box
  const std::string text = plain_text() + attachment("top", "box", 0.004);
  const Scene plain = scene_of(text, meshes);
  const std::vector<RestOverlap> overlaps = free_overlaps_at_rest(scene_of(plain_text(), meshes));
  EXPECT_GT(overlaps[0].nodes, 10);
  for (const TriangleMesh& shipped : {soup_of(meshes.ball), with_seam(meshes.ball)}) {
    Meshes foreign = meshes;
    foreign.ball = shipped;
    const Scene scene = scene_of(text, foreign);
    const auto less = [](const Vec3& a, const Vec3& b) {
      return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
    };
    std::vector<Vec3> expected = plain.muscle_mesh.vertices;
    std::vector<Vec3> nodes = scene.muscle_mesh.vertices;
    std::sort(expected.begin(), expected.end(), less);
    std::sort(nodes.begin(), nodes.end(), less);
    EXPECT_EQ(nodes, expected);
    EXPECT_EQ(MeshEdges(scene.muscle_mesh).count(), MeshEdges(plain.muscle_mesh).count());
    EXPECT_NEAR(surface_volume_m3(scene.muscle_mesh.vertices, scene.muscle_mesh.triangles),
                surface_volume_m3(plain.muscle_mesh.vertices, plain.muscle_mesh.triangles), 1e-18);
    EXPECT_EQ(scene.attachments[0].nodes.size(), plain.attachments[0].nodes.size());
    const std::vector<RestOverlap> found = free_overlaps_at_rest(scene_of(plain_text(), foreign));
    EXPECT_EQ(found[0].nodes, overlaps[0].nodes);
    EXPECT_EQ(found[0].deepest_m, overlaps[0].deepest_m);
    EXPECT_EQ(warnings_of(scene).find("merged"), std::string::npos) << "the format is like that";
    EXPECT_EQ(scene.muscles[0].file.mesh.vertices, shipped.vertices);
    EXPECT_EQ(scene.muscles[0].node_of_vertex.size(), shipped.vertices.size());
  }
}

TEST(ForeignScene, ASplitMuscleIsTheSameWhateverItsFormat) {
  Meshes meshes;
  const std::string text = plain_text() + "[meshes]\nsplit_muscles = 1\n";
  const Scene plain = scene_of(text, meshes);
  for (const TriangleMesh& shipped : {soup_of(meshes.ball), with_seam(meshes.ball)}) {
    Meshes foreign = meshes;
    foreign.ball = shipped;
    const Scene scene = scene_of(text, foreign);
    EXPECT_EQ(scene.muscle_mesh.vertices.size(), plain.muscle_mesh.vertices.size());
    EXPECT_EQ(MeshEdges(scene.muscle_mesh).count(), MeshEdges(plain.muscle_mesh).count());
    // What a run writes begins with the vertices of the file.
    EXPECT_TRUE(
        std::equal(shipped.vertices.begin(), shipped.vertices.end(), scene.muscles[0].file.mesh.vertices.begin()));
  }
}

TEST(ForeignScene, VerticesThatNoTriangleUsesAreNoNodes) {
  Meshes meshes;
  meshes.ball.vertices.insert(meshes.ball.vertices.begin(), Vec3(0, 0, 0));  // in the middle of the box
  for (Triangle& triangle : meshes.ball.triangles) {
    std::for_each(triangle.begin(), triangle.end(), [](int& vertex) { ++vertex; });
  }
  const Scene scene = scene_of(plain_text(), meshes);
  EXPECT_EQ(scene.muscle_mesh.vertices, Meshes().ball.vertices);
  EXPECT_EQ(free_overlaps_at_rest(scene)[0].nodes, 0);
  expect_mentions(warnings_of(scene), {"dropped 1 vertex that no triangle uses"});
}

TEST(ForeignScene, NodesThatBeginInABoneAreCounted) {
  Meshes meshes;
  meshes.ball = moved(make_sphere(0.01, 3), Vec3(0, 0, 0.018));
  expect_mentions(warnings_of(scene_of(plain_text(), meshes)), {"begin inside bone 'box'", "mm deep"});
  // Bound nodes may be inside, and with first_contact all that are inside are bound.
  const Scene bound = scene_of(plain_text() + attachment("top", "box", 0.01), meshes);
  EXPECT_EQ(free_overlaps_at_rest(bound)[0].nodes, 0);
  const std::string first_contact = warnings_of(scene_of("attachment = \"first_contact\"\n" + plain_text(), meshes));
  EXPECT_EQ(first_contact.find("begin inside"), std::string::npos) << first_contact;
}

TEST(ForeignScene, TheLikelyUnitIsNamed) {
  Meshes meshes;
  meshes.box = scaled(make_box(Vec3(0.05, 0.2, 0.05), 4), 1000);
  meshes.ball = scaled(moved(make_sphere(0.05, 3), Vec3(0, 0, 0.11)), 1000);
  expect_mentions(warnings_of(scene_of(plain_text(), meshes)), {"all meshes", "millimetres", "unit = \"mm\""});
  meshes.box = scaled(meshes.box, 0.1);
  meshes.ball = scaled(meshes.ball, 0.1);
  expect_mentions(warnings_of(scene_of(plain_text(), meshes)), {"all meshes", "centimetres", "unit = \"cm\""});
  meshes = {};
  meshes.ball = scaled(meshes.ball, 1000);
  std::string warnings = warnings_of(scene_of(plain_text(), meshes));
  expect_mentions(warnings, {"muscle 'ball' is", "out of step", "millimetres"});
  EXPECT_EQ(warnings.find("bone 'box' is"), std::string::npos) << warnings;
  meshes = {};
  meshes.box = scaled(make_box(Vec3(0.05, 0.2, 0.05), 4), 100);
  meshes.ball = moved(make_sphere(0.05, 3), Vec3(0, 0, 0.09));
  expect_mentions(warnings_of(scene_of(plain_text(), meshes)), {"bone 'box' is", "out of step", "centimetres"});
  meshes = {};
  meshes.ball = scaled(meshes.ball, 1e-3);
  expect_mentions(warnings_of(scene_of(plain_text(), meshes)), {"muscle 'ball'", "twice"});
}

TEST(ForeignScene, WhatIsFarAwayIsNamed) {
  Meshes meshes;
  meshes.ball.vertices[5].x() = 3.8e8;
  std::string warnings = warnings_of(scene_of(plain_text(), meshes));
  expect_mentions(warnings, {"muscle 'ball' has 1 vertex far outside", "3.8e+08 m"});
  EXPECT_EQ(warnings.find("millimetres"), std::string::npos) << warnings;
  meshes.ball = moved(make_sphere(0.01, 3), Vec3(0, 0, 1.5));
  expect_mentions(warnings_of(scene_of(plain_text(), meshes)), {"muscle 'ball' is 1.48 m away"});
  const auto turning_about = [](const std::string& centre) {
    std::string text = plain_text();
    return text.replace(text.find("[0, 0, 0]"), 9, centre);
  };
  expect_mentions(warnings_of(scene_of(turning_about("[0, 400, 0]"))), {"bone 'box' turns about a point 400 m away"});
  expect_mentions(error_of(request(turning_about("[0, 1e200, 0]"))), {"test.toml:9", "centre_m", "far away"});
}

TEST(ForeignScene, AnAxisOfAnyLengthIsADirection) {
  for (const char* axis : {"[0, 0, 1e200]", "[0, 0, 1e-200]", "[0, 0, 3]"}) {
    std::string text = plain_text();
    text.replace(text.find("[0, 0, 1]"), 9, axis);
    EXPECT_EQ(scene_of(text).motions[0].rotations[0].axis, Vec3(0, 0, 1)) << axis;
  }
}

TEST(ForeignScene, APieceThatHangsOnNothingIsNamed) {
  Meshes meshes;
  append(moved(make_sphere(0.002, 1), Vec3(0, 0, 0.05)), meshes.ball);
  expect_mentions(warnings_of(scene_of(plain_text(), meshes)), {"in 2 separate pieces"});
  expect_mentions(warnings_of(scene_of(plain_text() + attachment("top", "box", 0.004), meshes)),
                  {"in 2 separate pieces, 1 of them without a bound node"});
}

TEST(ForeignScene, MoreThanATurnIsNamed) {
  std::string text = plain_text();
  text.replace(text.find("to_deg = 90"), 11, "to_deg = -3438");
  expect_mentions(warnings_of(scene_of(text)), {"bone 'box' turns by 3438 degrees", "inDegrees"});
  text.replace(text.find("to_deg = -3438"), 14, "to_deg = 360");
  EXPECT_EQ(warnings_of(scene_of(text)), "");
}

TEST(ForeignScene, AnEmptyAttachmentSaysHowFarTheNearestNodeIs) {
  const Scene scene = scene_of(plain_text() + attachment("foot", "box", 0.0005));
  double lowest_m = 1;
  for (const Vec3& node : scene.muscle_mesh.vertices) {
    lowest_m = std::min(lowest_m, node.z());
  }
  expect_mentions(warnings_of(scene), {"attachment 'foot' binds no node",
                                       fmt::format("the nearest is {:.4g} mm from bone 'box'", 1e3 * (lowest_m - 0.01)),
                                       "distance_m allows 0.5 mm", "0 mm outside"});
  Meshes below;
  below.ball = moved(make_sphere(0.01, 3), -above);
  expect_mentions(warnings_of(scene_of(plain_text() + attachment("foot", "box", 0.0005), below)),
                  {"attachment 'foot' binds no node"});
}

TEST(ForeignScene, FibresThatCannotBeSayWhy) {
  const std::string second_bone = "[[bone]]\nname = \"lid\"\nmesh = \"synthetic:box\"\n";
  const std::string bones = std::string("preset = \"p\"\n") + bone_text + motion_text + second_bone + muscle_text +
                            "fibres = \"between_attachments\"\n";
  const auto complaint = [&](const std::string& areas, const Meshes& meshes = {}) {
    return error_of(request(bones + areas, meshes));
  };
  expect_mentions(complaint(""), {"test.toml:", "muscle.fibres", "no [[attachment]]"});
  expect_mentions(
      complaint(attachment("origin", "box", 0.004) + attachment("end", "lid", 0.0005)),
      {"attachment 'origin' has", "nodes on bone 'box'", "attachment 'end' binds no node", "the nearest is"});
  expect_mentions(complaint(attachment("origin", "box", 0.004) + attachment("end", "box", 0.003)),
                  {"all bound nodes are on bone 'box'"});
  Meshes in_millimetres;
  in_millimetres.ball = scaled(in_millimetres.ball, 1000);
  expect_mentions(complaint(attachment("origin", "box", 0.004), in_millimetres), {"muscle 'ball'", "millimetres"});
  SceneRequest look = request(bones + attachment("origin", "box", 0.0005));
  look.notes_obstacles = true;
  const Scene scene = read_scene(look);
  ASSERT_EQ(scene.obstacles.size(), 1U);
  expect_mentions(scene.obstacles[0], {"between_attachments", "origin"});
  expect_mentions(warnings_of(scene), {"attachment 'origin' binds no node"});
}

TEST(ForeignScene, AWrongParameterNamesItsOwnLine) {
  expect_mentions(error_of(request(plain_text() + "[loop]\n\nframes = 3\nsubsteps = 0\n")),
                  {"test.toml:19: loop", "substeps"});
}

TEST(ForeignScene, ARestThatLeavesNoFrameForTheMotionIsRefusedWhereItIsSaid) {
  const std::string loop = "[loop]\nframes = 3\nrest_frames = ";
  expect_mentions(error_of(request(plain_text() + loop + "3\n")), {"test.toml:18: loop.rest_frames", "3 of 3 frames"});
  EXPECT_EQ(error_of(request(plain_text() + loop + "2\n")), "no error");
  SceneRequest told = request(plain_text() + loop + "2\n");
  told.loop_overrides["rest_frames"] = std::int64_t{7};
  expect_mentions(error_of(told), {"--loop rest_frames", "7 of 3 frames"});
}

TEST(ForeignScene, KeysOfThousandsOfPartsAreRefused) {
  std::string key = "a";
  for (int i = 0; i < 50000; ++i) {
    key += ".a";
  }
  expect_mentions(error_of(request(plain_text() + key + " = 1\n")), {"test.toml:16", "dotted parts"});
  expect_mentions(error_of(request("[" + key + "]\n")), {"test.toml:1", "dotted parts"});
  // Dots of numbers, texts and remarks are no parts of a key.
  std::string text = "# " + key + "\ntitle = \"" + key + "\" # x\n" + plain_text();
  text += "[[attachment]]\nname = '''" + key + "'''\nbone = \"box\"\ndistance_m = 0.01\noutline_m = [";
  for (int i = 0; i < 100; ++i) {
    text += fmt::format("[0.{}, 0.001, 0.01], ", i);
  }
  EXPECT_EQ(error_of(request(text + "]\n")), "no error");
}

TEST(ForeignScene, AnAttachmentSaysWhatItsNodesAreNear) {
  // The outline lies in the plane of the box's top: with enough distance, as many nodes as the box binds, or more.
  const std::string text = plain_text() + attachment("top", "box", 0.004);
  const std::size_t near_bone = scene_of(text).attachments[0].nodes.size();
  EXPECT_GT(near_bone, 0U);
  EXPECT_GE(scene_of(text + "near = \"outline\"\n").attachments[0].nodes.size(), near_bone);
  expect_mentions(
      error_of(request(text + "near = \"otline\"\n")),
      {"test.toml:22: attachment[1].near", "'otline' has to be bone, outline or points; did you mean 'outline'?"});
}

TEST(ForeignScene, ASceneSaysWhoseShapesItHas) {
  EXPECT_EQ(scene_of(plain_text()).source.licence, "");
  const Scene scene = scene_of(plain_text() + "[source]\nlicence = \"CC BY 4.0\"\ncite = [\"A\", \"B\"]\n");
  EXPECT_EQ(scene.source.licence, "CC BY 4.0");
  EXPECT_EQ(scene.source.citations, (std::vector<std::string>{"A", "B"}));
  EXPECT_FALSE(scene.source.is_non_commercial);
  EXPECT_TRUE(scene_of(plain_text() + "[source]\nlicence = \"X\"\nnon_commercial = true\n").source.is_non_commercial);
  expect_mentions(error_of(request(plain_text() + "[source]\nurl = \"x\"\n")), {"source.licence", "missing"});
  expect_mentions(error_of(request(plain_text() + "[source]\nlicense = \"x\"\n")), {"licence"});
}

TEST(ForeignScene, AnAttachmentOfPointsBindsWhatWasPicked) {
  const std::string table = "[[attachment]]\nname = \"picked\"\nbone = \"box\"\nnear = \"points\"\n";
  const Scene scene = scene_of(plain_text() + attachment("top", "box", 0.004));
  const Vec3 node = scene.muscle_mesh.vertices[7];
  const std::string at = fmt::format("outline_m = [[{}, {}, {}]]\n", node.x(), node.y(), node.z());
  EXPECT_EQ(scene_of(plain_text() + table + at + "distance_m = 1e-6\n").attachments[0].nodes, std::vector{7});
  expect_mentions(error_of(request(plain_text() + table + at + "distance_m = 1e-6\nmargin_m = 0.1\n")),
                  {"attachment[1].margin_m", "points have no area"});
  expect_mentions(error_of(request(plain_text() + table + "outline_m = []\ndistance_m = 1e-6\n")), {"point"});
  const Scene far = scene_of(plain_text() + table + "outline_m = [[0.5, 0, 0]]\ndistance_m = 1e-6\n");
  EXPECT_NE(describe_empty_attachment(far, far.attachments[0]).find("mm from its points"), std::string::npos);
}

TEST(ForeignScene, MoreBodiesThanAnySceneHasAreRefusedBeforeOneIsRead) {
  for (const std::string kind : {"bone", "muscle"}) {
    std::string text = kind == "bone" ? "" : "[[bone]]\nname = \"b\"\nmesh = \"synthetic:box\"\n";
    for (int i = 0; i < 1001; ++i) text += "[[" + kind + "]]\nname = \"" + kind + std::to_string(i) + "\"\n";
    const std::string message = error_of(request(text));
    EXPECT_NE(message.find(kind + ": lists 1001 of them"), std::string::npos) << message;
  }
}

/// The same side twice, and a plane alone: neither has an inside.
TEST(ForeignScene, ABoneWithoutVolumeIsRefused) {
  Meshes sheet;
  sheet.box = make_box(Vec3(0.02, 0.03, 0.01), 4);
  for (Vec3& vertex : sheet.box.vertices) vertex.z() = 0.01 + 1e-9 * vertex.z();
  expect_mentions(error_of(request(plain_text(), sheet)), {"test.toml", "bone", "synthetic:box", "no volume"});
  sheet.box = make_box(Vec3(0.02, 0.03, 2e-6), 4);  // a foil of 4 um has one
  EXPECT_NO_THROW((void)scene_of(plain_text(), sheet));
}

TEST(ForeignScene, ABoneWithSmallHolesIsWarnedOf) {
  Meshes meshes;
  meshes.box = make_sphere(0.01, 4);
  EXPECT_EQ(warnings_of(scene_of(plain_text(), meshes)), "");
  meshes.box.triangles.erase(meshes.box.triangles.begin() + 7);
  expect_mentions(warnings_of(scene_of(plain_text(), meshes)), {"bone 'box'", "closed 1 hole (3 boundary edges)"});
}

TEST(ForeignScene, TwoMusclesOfOneMeshAreRefused) {
  const std::string text = std::string("preset = \"p\"\n") + bone_text + motion_text +
                           "[[muscle]]\nname = \"ball\"\nmesh = \"synthetic:ball\"\n"
                           "[[muscle]]\nname = \"other\"\nmesh = \"synthetic:ball\"\n";
  expect_mentions(error_of(request(text)), {"test.toml", "synthetic:ball", "muscle 'ball'", "same place"});
}

TEST(ForeignScene, ATableThatIsAPipeIsRefused) {
  const TemporaryFolder folder;
  const std::string pipe = (folder / "pipe.mot").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::string text = plain_text();
  text.replace(text.find("from_deg = 0\nto_deg = 90"), 24, "table = \"" + pipe + "\"\ncolumn = \"hip\"");
  expect_mentions(error_of(request(text)), {pipe, "pipe"});
}

}  // namespace
}  // namespace musclebench

// Meshes of strangers, in their units and frames.
#include "core/scene/mesh_placement.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/temporary_folder.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/surface_volume.hpp"
#include "core/mesh_files/read_mesh.hpp"
#include "core/scene/read_scene.hpp"
#include "core/scene/scene_warnings.hpp"
#include "core/scene/tests/scene_errors.hpp"

namespace musclebench {
namespace {

/// A ball of 40 mm above a bone of 200 mm, in metres.
TriangleMesh ball_in_metres() {
  TriangleMesh ball = make_sphere(0.02, 3);
  for (Vec3& vertex : ball.vertices) vertex += Vec3(0, 0, 0.121);
  return ball;
}

void write_stl(const TriangleMesh& mesh, double factor, const std::filesystem::path& path) {
  std::ofstream file(path);
  file << "solid from_elsewhere\n";
  for (const Triangle& triangle : mesh.triangles) {
    file << "facet normal 0 0 0\nouter loop\n";
    for (const int corner : triangle) {
      const Vec3 v = factor * mesh.vertices[static_cast<std::size_t>(corner)];
      file << fmt::format("vertex {:.17g} {:.17g} {:.17g}\n", v.x(), v.y(), v.z());
    }
    file << "endloop\nendfacet\n";
  }
  file << "endsolid from_elsewhere\n";
}

class PlacedMesh : public testing::Test {
 protected:
  void SetUp() override {
    write_stl(ball_in_metres(), 1000, m_folder / "ball_mm.stl");
    write_stl(ball_in_metres(), 1, m_folder / "ball_m.stl");
    write_ply(make_box(Vec3(0.03, 0.03, 0.1), 4), m_folder / "bone.ply");
  }

  [[nodiscard]] SceneRequest request(const std::string& mesh, const std::string& keys,
                                     const std::string& bone_keys = "") const {
    SceneRequest request;
    request.name = "test";
    request.file = "test.toml";
    request.folder = m_folder.path();
    request.text = fmt::format(
        "[[bone]]\nname = \"bone\"\nmesh = \"bone.ply\"\n{}[muscle]\nname = \"ball\"\nmesh = "
        "\"{}\"\n{}[[attachment]]\nname = \"low\"\nbone = \"bone\"\ndistance_m = 0.004\n"
        "outline_m = [[-0.02, -0.02, 0.1], [0.02, -0.02, 0.1], [0.02, 0.02, 0.1]]\n",
        bone_keys, mesh, keys);
    return request;
  }
  [[nodiscard]] Scene scene(const std::string& mesh, const std::string& keys) const {
    return read_scene(request(mesh, keys));
  }
  [[nodiscard]] std::string warnings(const std::string& mesh, const std::string& keys) const {
    return text_of(scene_warnings(scene(mesh, keys)), {"cleaned_muscle", "empty_attachment"});
  }
  /// Those of other rules.
  [[nodiscard]] static std::string text_of(const std::vector<SceneWarning>& warnings,
                                           const std::vector<std::string>& without) {
    std::string all;
    for (const SceneWarning& warning : warnings) {
      if (std::ranges::find(without, warning.rule) == without.end()) all += warning.text + "\n";
    }
    return all;
  }
  /// The ball with an outline and a fibre of a file, all turned and moved alike, or the bone's keys alone.
  [[nodiscard]] Scene scene_of_landmarks(const std::string& keys, const std::string& bone_keys) const {
    std::ofstream(m_folder / "marks.json") << R"({"attachments": [{"muscle": "ball", "role": "origin",
        "points_m": [[-0.02, -0.02, 0.1], [0.02, -0.02, 0.1], [0.02, 0.02, 0.1]]}],
        "fibres": [{"muscle": "ball", "polylines_m": [[[0, 0, 0.11], [0, 0, 0.12], [0.01, 0, 0.13]]]}]})";
    SceneRequest with_files = request("ball_mm.stl", "unit = \"mm\"\nfibres = \"marks.json#ball\"\n" + keys, bone_keys);
    const std::size_t at = with_files.text.find("outline_m");
    with_files.text.replace(at, std::string::npos, "outline = \"marks.json#ball/origin\"\n");
    return read_scene(with_files);
  }

 private:
  TemporaryFolder m_folder;
};

double farthest(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double farthest_m = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
    farthest_m = std::max(farthest_m, (a[i] - b[i]).norm());
  }
  return farthest_m;
}

TEST_F(PlacedMesh, AnStlInMillimetresBesideABoneInMetresIsToldAndMendedByTheProposedLine) {
  const std::string told = warnings("ball_mm.stl", "");
  expect_mentions(told, {"muscle 'ball'", "millimetres", "unit = \"mm\" in its table (test.toml:4)"});
  EXPECT_EQ(warnings("ball_mm.stl", "unit = \"mm\"\n"), "");
  const Scene in_metres = scene("ball_m.stl", "");
  for (const char* keys : {"unit = \"mm\"\n", "scale = 0.001\n", "unit = \"cm\"\nscale = [0.1, 0.1, 0.1]\n"}) {
    const Scene placed = scene("ball_mm.stl", keys);
    EXPECT_LT(farthest(placed.muscle_mesh.vertices, in_metres.muscle_mesh.vertices), 1e-15) << keys;
    EXPECT_GT(placed.attachments[0].nodes.size(), 3U);
    EXPECT_EQ(placed.attachments[0].nodes, in_metres.attachments[0].nodes) << keys;
    EXPECT_EQ(placed.muscles[0].file.mesh.vertices.size(), in_metres.muscles[0].file.mesh.vertices.size());
  }
}

/// Bits and all where the file's number is exact, so that a run ends in the same state.
TEST(MeshPlacement, MillimetresReadAsTheSameNumbersInMetres) {
  for (int i = 1; i <= 1000; ++i) {
    std::vector<Vec3> millimetres = {{1.0 * i, -0.5 * i, -0.0}};
    MeshPlacement{.units_per_metre = 1000}.apply_to(millimetres);
    EXPECT_EQ(millimetres[0], Vec3(std::stod(fmt::format("{}e-3", i)), -std::stod(fmt::format("{}e-4", 5 * i)), 0));
    EXPECT_TRUE(std::signbit(millimetres[0].z()));
  }
}

TEST_F(PlacedMesh, AHashIsThatOfTheMeshWhereItIs) {
  const std::string as_it_is = scene("ball_m.stl", "").muscles[0].file.sha256;
  const std::string same =
      scene("ball_m.stl", "unit = \"m\"\nscale = 1\nrotate_deg = [0, 0, 0]\n").muscles[0].file.sha256;
  EXPECT_EQ(same, as_it_is);
  for (const char* keys :
       {"unit = \"cm\"\n", "scale = 1.01\n", "rotate_deg = [0, 0, 1]\n", "translate_m = [0, 0, 1e-3]\n"}) {
    EXPECT_NE(scene("ball_m.stl", keys).muscles[0].file.sha256, as_it_is) << keys;
  }
}

/// Scaled along the mesh's own axes, turned about the scene's x, y and z, then moved.
TEST(MeshPlacement, ScalesThenTurnsAboutXYAndZThenMoves) {
  std::vector<Vec3> points = {{1, 2, 3}};
  MeshPlacement{.units_per_metre = 100, .scale = {2, 1, 1}, .rotate_deg = {90, 0, 90}, .translate_m = {1, 0, 0}}
      .apply_to(points);
  // (0.02, 0.02, 0.03), about x: (0.02, -0.03, 0.02), about z: (0.03, 0.02, 0.02).
  EXPECT_EQ(points[0], Vec3(1.03, 0.02, 0.02));
  points = {{0, 0, 1}};
  MeshPlacement{.rotate_deg = {0, 30, 0}}.apply_to(points);
  EXPECT_LT((points[0] - Vec3(0.5, 0, std::sqrt(0.75))).norm(), 1e-15);
}

TEST_F(PlacedMesh, BonesAreMovedAsMusclesAre) {
  const Scene moved = read_scene(request("ball_m.stl", "", "rotate_deg = [0, 90, 0]\ntranslate_m = [0, 0, 0.07]\n"));
  Eigen::AlignedBox3d box;
  for (const Vec3& vertex : moved.bones[0].surface.mesh.vertices) box.extend(vertex);
  EXPECT_LT((box.max() - Vec3(0.1, 0.03, 0.1)).norm(), 1e-15);
  EXPECT_GT(surface_volume_m3(moved.bones[0].surface.mesh.vertices, moved.bones[0].surface.mesh.triangles), 0);
}

constexpr const char* placed = "scale = 2\nrotate_deg = [0, 90, 0]\ntranslate_m = [0, 0, 0.07]\n";

TEST_F(PlacedMesh, PointsOfFilesFollowTheMeshThatTheyDescribeButForItsUnit) {
  const Scene as_it_is = scene_of_landmarks("", "");
  EXPECT_EQ(as_it_is.muscles[0].fibres.at(1).end, Vec3(0.01, 0, 0.13));
  const Scene moved = scene_of_landmarks(placed, placed);
  ASSERT_EQ(moved.muscles[0].fibres.size(), 2U);
  // (0.02, 0, 0.26) about y: (0.26, 0, -0.02).
  EXPECT_LT((moved.muscles[0].fibres[1].end - Vec3(0.26, 0, 0.05)).norm(), 1e-15);
  EXPECT_LT((moved.muscles[0].fibres[0].start - Vec3(0.22, 0, 0.07)).norm(), 1e-15);
  EXPECT_LT((moved.attachments[0].area.outline_m[1] - Vec3(0.2, -0.04, 0.03)).norm(), 1e-15);
  EXPECT_GT(moved.attachments[0].nodes.size(), 3U);
  EXPECT_EQ(text_of(scene_warnings(moved), {"cleaned_muscle"}), "");
}

TEST_F(PlacedMesh, PointsOfTheSceneStayWhereTheyAre) {
  const Scene moved = read_scene(request("ball_m.stl", "", placed));
  EXPECT_EQ(moved.attachments[0].area.outline_m[0], Vec3(-0.02, -0.02, 0.1));
}

TEST_F(PlacedMesh, FibresThatLieOutsideTheirMuscleAreToldWithTheCure) {
  const Scene scaled = scene_of_landmarks("scale = 0.5\ntranslate_m = [0, 0, 0.0605]\n", "");
  EXPECT_EQ(text_of(scene_warnings(scaled), {"cleaned_muscle", "empty_attachment", "overlap_with_bone"}), "");
  Scene off = scene_of_landmarks("", "");
  for (FibreSegment& fibre : off.muscles[0].fibres) {
    fibre.start /= 1000;
    fibre.end /= 1000;
  }
  expect_mentions(text_of(scene_warnings(off), {"cleaned_muscle"}),
                  {"muscle 'ball'", "4 of 4 points", "test.toml:4", "metres", "scale, rotate_deg and translate_m",
                   "unit does not"});
}

TEST_F(PlacedMesh, AnOutlineOfAFileThatBindsNothingTellsWhatPlacedIt) {
  const auto told = [&](const Scene& scene) { return text_of(scene_warnings(scene), {"cleaned_muscle"}); };
  expect_mentions(told(scene_of_landmarks("", placed)),
                  {"binds no node", "scale, rotate_deg and translate_m of bone 'bone'", "outline_m"});
  EXPECT_EQ(told(scene_of_landmarks("translate_m = [0, 0, 0.1]\n", "")).find("of bone 'bone' move"), std::string::npos);
}

TEST_F(PlacedMesh, WhatCannotBeIsRefusedInOneLine) {
  const auto complaint = [&](const std::string& keys) { return error_of(request("ball_m.stl", keys)); };
  expect_mentions(complaint("unit = \"inch\"\n"), {"test.toml:7: muscle.unit", "'inch' is not one of mm, cm, m"});
  expect_mentions(complaint("scale = -1\n"), {"test.toml:7: muscle.scale", "inside out", "in its file"});
  expect_mentions(complaint("scale = [1, -1, 1]\n"), {"muscle.scale", "inside out"});
  expect_mentions(complaint("scale = 0\n"), {"muscle.scale", "from 1e-09"});
  expect_mentions(complaint("scale = [1, 2]\n"), {"muscle.scale", "three finite numbers"});
  expect_mentions(complaint("rotate_deg = [0, 1e5, 0]\n"), {"muscle.rotate_deg", "beyond 3600"});
  expect_mentions(complaint("translate_m = [1e200, 0, 0]\n"), {"muscle.translate_m", "beyond 1e+09"});
  expect_mentions(complaint("translate = [1, 0, 0]\n"), {"did you mean 'translate_m'?"});
}

TEST_F(PlacedMesh, AUnitThatDoesNotFitIsCheckedAgain) {
  expect_mentions(warnings("ball_m.stl", "scale = 1000\n"), {"muscle 'ball'", "check unit and scale in its table"});
  expect_mentions(warnings("ball_m.stl", "unit = \"mm\"\n"), {"twice", "unit and scale", "(test.toml:4)"});
}

TEST_F(PlacedMesh, TheSameMeshTwiceIsTwoMusclesWhereTheyLieApart) {
  const auto two = [&](const std::string& keys) {
    SceneRequest both = request("ball_m.stl", "");
    const std::size_t at = both.text.find("[muscle]");
    both.text.replace(at, 8, "[[muscle]]\nname = \"other\"\nmesh = \"ball_m.stl\"\n" + keys + "[[muscle]]");
    both.text += "muscle = \"ball\"\n";
    return error_of(both);
  };
  expect_mentions(two(""), {"muscle 'other'", "same place"});
  EXPECT_EQ(two("translate_m = [0.1, 0, 0]\n"), "no error");
}

}  // namespace
}  // namespace musclebench

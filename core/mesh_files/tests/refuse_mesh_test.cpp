// What is no mesh, or a damaged one, is refused in one line that names the file and the location.
#include <cmath>
#include <random>
#include <string>
#include <sys/stat.h>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/mesh_files/polygon_mesh.hpp"
#include "core/mesh_files/tests/mesh_files.hpp"

namespace musclebench {
namespace {

using RefuseMesh = MeshFiles;

TEST_F(RefuseMesh, RefusesToWriteWhereItCannot) {
  const TriangleMesh mesh = make_sphere(0.1, 0);
  write_ply(mesh, path("file.ply"));
  EXPECT_THROW(write_ply(mesh, path("file.ply") / "a.ply"), InputError);
  fs::create_directories(path("folder.ply") / "full");
  EXPECT_THROW(write_ply(mesh, path("folder.ply")), InputError);
}

TEST_F(RefuseMesh, RefusesWhatIsNoMeshFile) {
  expect_refused(path("missing.ply"), "no such file");
  fs::create_directories(path("folder.ply"));
  expect_refused(path("folder.ply"), "folder");
  for (const std::string ending : {"ply", "obj", "off", "stl", "gltf", "xyzzy"}) {
    expect_refused("empty." + ending, "", "is empty");
  }
  expect_refused("a.xyzzy", hand_ply, "ending");
  expect_refused("noending", hand_ply, "ending");
  expect_refused("a.ply", hand_off, "PLY header");
  expect_refused("a.off", hand_ply, "line 1");
  expect_refused("a.stl", hand_ply, "STL");
  expect_refused("a.obj", hand_off, "no triangles");
}

TEST_F(RefuseMesh, RefusesBinaryGarbage) {
  std::mt19937 random(4);
  const std::vector<std::pair<std::string, std::string>> beginnings = {
      {"ply", hand_ply_header},
      {"ply", hand_ply.substr(0, 20)},
      {"ply", "ply\nformat binary_little_endian 1.0\n"},
      {"off", "OFF\n6 3 0\n"},
      {"off", "OFF\n"},
      {"obj", "v 0 0 0\n"},
      {"stl", "solid a\n"},
      {"ply", ""},
      {"off", ""},
      {"obj", ""},
      {"stl", ""}};
  for (int round = 0; round < 5; ++round) {
    for (const auto& [ending, beginning] : beginnings) {
      std::string garbage = beginning;
      for (int i = 0; i < 3000; ++i) {
        garbage += static_cast<char>(random() & 0xFFU);
      }
      expect_refused("garbage." + ending, garbage, "");
    }
  }
}

TEST_F(RefuseMesh, RefusesPipesAndDevices) {
  ASSERT_EQ(mkfifo(path("pipe.ply").c_str(), 0600), 0);
  expect_refused(path("pipe.ply"), "pipe");
  fs::create_symlink("/dev/zero", path("endless.ply"));
  expect_refused(path("endless.ply"), "device");
}

TEST_F(RefuseMesh, TellsAHugeFileOfGarbageByItsHead) {
  constexpr std::uintmax_t more_than_memory = std::uintmax_t{1} << 42;
  for (const auto& [ending, part] : std::vector<std::pair<std::string, std::string>>{
           {"ply", "PLY header"}, {"obj", "no text"}, {"off", "no text"}, {"stl", "STL"}}) {
    const fs::path file = write("huge." + ending, "");
    std::error_code error;
    fs::resize_file(file, more_than_memory, error);  // a hole, which takes no room
    if (error) {
      GTEST_SKIP() << "the folder of temporary files has no files with holes";
    }
    expect_refused(file, part);
  }
  const fs::path file = write("huge.ply", hand_ply);
  fs::resize_file(file, more_than_memory);
  expect_refused(file, "MB");
}

TEST_F(RefuseMesh, RefusesPolygonsThatTakeForeverToCut) {
  std::string vertices;
  std::string face = "f";
  for (int i = 1; i <= 1001; ++i) {
    const double angle = 0.006 * i;
    vertices += fmt::format("v {} {} 0\n", std::cos(angle), std::sin(angle));
    face += fmt::format(" {}", i);
  }
  expect_refused("large.obj", vertices + face + "\n", "face 0 (counted from 0) has more than 1000 corners");
  const TriangleMesh cut = read_mesh(write("large.obj", vertices + face.substr(0, face.rfind(' ')) + "\n"));
  EXPECT_EQ(cut.triangles.size(), 998U);
}

using Parser = PolygonMesh (*)(std::string_view, const std::string&);

/// In memory, for the many variants of one file.
bool is_refused(Parser parse, const std::string& content) {
  try {
    const PolygonMesh polygons = parse(content, "file");
    for (const Triangle& triangle : split_into_triangles(polygons)) {
      for (const int vertex : triangle) {
        EXPECT_TRUE(vertex >= 0 && vertex < static_cast<int>(polygons.vertices.size()));
      }
    }
    return false;
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find("file: "), 0U);
    return true;
  }
}

TEST(ParseMesh, SurvivesAnyBentByte) {
  std::mt19937 random(5);
  const std::vector<std::pair<Parser, std::string>> files = {
      {parse_ply, hand_ply}, {parse_ply, binary_ply(false)}, {parse_off, hand_off},
      {parse_obj, hand_obj}, {parse_stl, ascii_stl},         {parse_stl, binary_stl(make_box(Vec3(1, 1, 1), 1))}};
  for (const auto& [parse, content] : files) {
    EXPECT_FALSE(is_refused(parse, content));
    int refused = 0;
    for (std::size_t offset = 0; offset < content.size(); ++offset) {
      std::string bent = content;
      bent[offset] = static_cast<char>(random() & 0xFFU);
      refused += is_refused(parse, bent) ? 1 : 0;
    }
    EXPECT_GT(refused, 0);
  }
}

TEST(ParseMesh, RefusesEveryTruncation) {
  const std::string binary = binary_ply(true);
  for (std::size_t size = 0; size < binary.size(); ++size) {
    EXPECT_TRUE(is_refused(parse_ply, binary.substr(0, size))) << size;
  }
  // Not the last bytes of a text: without its line end a last line is still whole.
  for (std::size_t size = 0; size + 3 < hand_ply.size(); ++size) {
    EXPECT_TRUE(is_refused(parse_ply, hand_ply.substr(0, size))) << size;
  }
  for (std::size_t size = 0; size + 3 < hand_off.size(); ++size) {
    EXPECT_TRUE(is_refused(parse_off, hand_off.substr(0, size))) << size;
  }
  const std::string stl = binary_stl(make_box(Vec3(1, 1, 1), 1));
  for (std::size_t size = 0; size < stl.size(); ++size) {
    EXPECT_TRUE(is_refused(parse_stl, stl.substr(0, size))) << size;
  }
  // A text of several solids may end after any of them, and the name of a solid is free.
  const std::size_t second_solid = ascii_stl.find("solid b");
  for (std::size_t size = second_solid + 8; size + 10 < ascii_stl.size(); ++size) {
    EXPECT_TRUE(is_refused(parse_stl, ascii_stl.substr(0, size))) << size;
  }
}

TEST_F(RefuseMesh, RefusesTruncatedFiles) {
  expect_refused("cut.ply", hand_ply.substr(0, hand_ply.find("0 1 0\n")), "ends after 3 of 6 elements 'vertex'");
  expect_refused("cut2.ply", binary_ply(false).substr(0, binary_ply(false).size() - 1), "ends after 5 of 6");
  expect_refused("cut.off", hand_off.substr(0, hand_off.find("4 4")), "ends after 1 of 3 faces");
  expect_refused("cut.stl", binary_stl(make_box(Vec3(1, 1, 1), 1)).substr(0, 300), "12 facets");
  expect_refused("cut2.stl", ascii_stl.substr(0, ascii_stl.find("endsolid")), "cut off");
  expect_refused("cut.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2", "line 5");
  expect_refused("cut2.obj", "v 0 0 0\nv 1 0 0\nv 0 1", "line 3");
  expect_refused("cut3.obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n", "only 2 vertices");
}

TEST_F(RefuseMesh, RefusesIndicesOutOfRange) {
  for (const std::string index : {"6", "-1", "4294967296", "1.5", "1e300", "nan"}) {
    expect_refused("a.ply", replaced(hand_ply, "3 2 1 3\n", "3 2 1 " + index + "\n"), "face 2");
    expect_refused("a.off", replaced(hand_off, "3 2 1 3\n", "3 2 1 " + index + "\n"), "face 2");
  }
  for (const std::string index : {"7", "0", "-7", "99999999999999999999", "x", "/1"}) {
    expect_refused("a.obj", replaced(hand_obj, "f 3 2 4\n", "f 3 2 " + index + "\n"), "");
  }
  std::string binary = binary_ply(false);
  binary[binary.find("end_header\n") + 11 + 3] = 6;
  expect_refused("b.ply", binary, "face 0 refers to vertex 6");
}

TEST_F(RefuseMesh, RefusesVerticesThatAreNotFinite) {
  for (const std::string value : {"nan", "-nan", "inf", "-inf", "NaN", "1e39"}) {
    const std::string bad = "0.3333333333333333 " + value + " 0";
    expect_refused("a.ply", replaced(hand_ply, "0.3333333333333333 1 0", bad), "vertex 5");
    expect_refused("a.off", replaced(hand_off, "0.3333333333333333 1 0", bad), "vertex 5");
    expect_refused("a.obj", replaced(hand_obj, "0.3333333333333333 1 0", bad), "vertex 5");
    expect_refused("a.stl", replaced(ascii_stl, "vertex 1 1 0", "vertex 1 " + value + " 0"), "vertex 4");
  }
  for (const double value : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    TriangleMesh mesh = make_box(Vec3(1, 1, 1), 1);
    mesh.vertices[3].z() = value;
    write_ply(mesh, path("b.ply"));
    expect_refused(path("b.ply"), "vertex 3");
  }
}

TEST_F(RefuseMesh, RefusesWhatHasNoSurface) {
  expect_refused("a.ply", replaced(hand_ply_header, "face 3", "face 0") + hand_coordinates, "no triangles");
  expect_refused("b.ply", hand_ply_header + hand_coordinates + "2 1 2\n1 0\n0\n", "no triangles");
  expect_refused("a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n3 0 0 1\n", "without area");
  expect_refused("b.off", "OFF\n5 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 0\n4 0 0\n5 0 1 2 3 4\n", "without area");
  expect_refused("c.off", "OFF\n0 0 0\n", "no triangles");
  expect_refused("a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n", "no triangles");
  expect_refused("a.stl", "solid a\nendsolid a\n", "no triangles");
  expect_refused("b.stl", binary_stl(TriangleMesh{}), "no triangles");
}

TEST_F(RefuseMesh, RefusesPromisesThatNoFileCanKeep) {
  expect_refused("a.ply", replaced(hand_ply, "vertex 6", "vertex 99999999999"), "line 3");
  expect_refused("b.ply", replaced(hand_ply, "vertex 6", "vertex 2000000000"), "");
  expect_refused("c.ply", replaced(binary_ply(false), "vertex 6", "vertex 2000000000"), "ends after 6 of 2000000000");
  expect_refused("d.ply", replaced(hand_ply, "4 4 2 5 3", "200000000 4 2 5 3"), "too few");
  expect_refused("e.ply", replaced(hand_ply, "property double y\n", ""), "x, y and z");
  expect_refused("f.ply", replaced(hand_ply, "format ascii 1.0\n", ""), "format");
  expect_refused("g.ply", replaced(hand_ply, "double x", "quadruple x"), "line 4");
  expect_refused("a.off", replaced(hand_off, "6 3 0", "6 2000000000 0"), "ends after 3 of 2000000000 faces");
  expect_refused("b.off", replaced(hand_off, "OFF\n", "4OFF\n"), "plain OFF");
  expect_refused("c.off", replaced(hand_off, "OFF\n", "OFF BINARY\n"), "binary OFF");
  expect_refused("a.obj", replaced(hand_obj, "v 1 0 0\n", "v 1 0 0 2\n"), "weight");
}

}  // namespace
}  // namespace musclebench

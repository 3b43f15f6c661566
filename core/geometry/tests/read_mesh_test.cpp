#include "core/geometry/read_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <random>
#include <string>
#include <unistd.h>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/geometry/check_mesh.hpp"
#include "core/geometry/polygon_mesh.hpp"
#include "core/geometry/shapes.hpp"
#include "core/geometry/tests/lhdl_data.hpp"

namespace musclebench {
namespace {

namespace fs = std::filesystem;

/// Files in a folder of its own, which goes with the test.
class ReadMesh : public testing::Test {
 protected:
  ReadMesh()
      : m_folder(fs::temp_directory_path() / ("musclebench_read_mesh_" + std::to_string(getpid()) + "_" +
                                              testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::create_directories(m_folder);
  }
  ~ReadMesh() override {
    std::error_code ignored;
    fs::remove_all(m_folder, ignored);
  }

  [[nodiscard]] fs::path path(const std::string& name) const { return m_folder / name; }

  [[nodiscard]] fs::path write(const std::string& name, const std::string& content) const {
    std::ofstream(path(name), std::ios::binary) << content;
    return path(name);
  }

  /// The file is refused in one line that begins with its path and holds `part`.
  static void expect_refused(const fs::path& file, const std::string& part) {
    try {
      read_mesh(file);
      ADD_FAILURE() << file << " was accepted";
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.find(file.string() + ": "), 0U) << message;
      EXPECT_NE(message.find(part), std::string::npos) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
  }

  void expect_refused(const std::string& name, const std::string& content, const std::string& part) const {
    SCOPED_TRACE(name);
    expect_refused(write(name, content), part);
  }

 private:
  fs::path m_folder;
};

/// Six vertices, the first unreferenced, the second and fifth at one position, a quadrangle among the faces.
const std::vector<Vec3> hand_vertices = {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1.0 / 3, 1, 0}};
const std::string hand_coordinates = "9 9 9\n0 0 0\n1 0 0\n0 1 0\n0 0 0\n0.3333333333333333 1 0\n";
const std::string hand_ply_header =
    "ply\nformat ascii 1.0\nelement vertex 6\nproperty double x\nproperty double y\nproperty double z\n"
    "element face 3\nproperty list uchar int vertex_indices\nend_header\n";
const std::string hand_ply = hand_ply_header + hand_coordinates + "3 1 2 3\n4 4 2 5 3\n3 2 1 3\n";
const std::string hand_off = "OFF\n6 3 0\n" + hand_coordinates + "3 1 2 3\n4 4 2 5 3\n3 2 1 3\n";
const std::string hand_obj =
    "# by hand\nmtllib none.mtl\no first\nv 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 2/1/1 3/1/1 4/1/1\n"
    "v 0 0 0\nv 0.3333333333333333 1 0\ng second\nusemtl red\nf -2//1 -4//1 6//1 4//1\nl 1 2\nf 3 2 4\n";

void expect_hand_mesh(const TriangleMesh& mesh) {
  EXPECT_EQ(mesh.vertices, hand_vertices);
  ASSERT_EQ(mesh.triangles.size(), 4U);
  EXPECT_EQ(mesh.triangles[0], (Triangle{1, 2, 3}));
  EXPECT_EQ(mesh.triangles[3], (Triangle{2, 1, 3}));
  // The quadrangle may be cut either way; both ways keep its area and winding.
  Vec3 area_normal = Vec3::Zero();
  for (const int t : {1, 2}) {
    const Vec3 a = mesh.vertices[mesh.triangles[t][0]];
    const Vec3 b = mesh.vertices[mesh.triangles[t][1]];
    const Vec3 c = mesh.vertices[mesh.triangles[t][2]];
    area_normal += (b - a).cross(c - a) / 2;
    for (const int vertex : mesh.triangles[t]) {
      EXPECT_TRUE(vertex == 4 || vertex == 2 || vertex == 5 || vertex == 3) << vertex;
    }
  }
  EXPECT_NEAR(area_normal.z(), 2.0 / 3, 1e-15);
}

std::string with_crlf(const std::string& text) {
  std::string out;
  for (const char c : text) {
    out += c == '\n' ? "\r\n" : std::string(1, c);
  }
  return out;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return text.replace(place, from.size(), to);
}

template <typename T>
void append(std::string& bytes, T value, bool is_big_endian) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (is_big_endian) {
    std::reverse(raw, raw + sizeof(T));
  }
  bytes.append(raw, sizeof(T));
}

/// The hand-made mesh with everything that PLY allows: faces first, strange types, further properties and elements.
std::string binary_ply(bool is_big_endian) {
  std::string text = std::string("ply\nformat binary_") + (is_big_endian ? "big" : "little") +
                     "_endian 1.0\ncomment x\nelement face 3\nproperty uchar flag\n"
                     "property list ushort uint vertex_index\nproperty list uchar float texcoord\n"
                     "element edge 1\nproperty int vertex1\nelement vertex 6\nproperty double x\nproperty uchar red\n"
                     "property double y\nproperty double z\nend_header\n";
  const std::vector<std::vector<std::uint32_t>> faces = {{1, 2, 3}, {4, 2, 5, 3}, {2, 1, 3}};
  for (const auto& face : faces) {
    append<std::uint8_t>(text, 7, is_big_endian);
    append(text, static_cast<std::uint16_t>(face.size()), is_big_endian);
    for (const std::uint32_t vertex : face) {
      append(text, vertex, is_big_endian);
    }
    append<std::uint8_t>(text, 1, is_big_endian);
    append<float>(text, 0.5F, is_big_endian);
  }
  append<std::int32_t>(text, 3, is_big_endian);
  for (const Vec3& vertex : hand_vertices) {
    append(text, vertex.x(), is_big_endian);
    append<std::uint8_t>(text, 255, is_big_endian);
    append(text, vertex.y(), is_big_endian);
    append(text, vertex.z(), is_big_endian);
  }
  return text;
}

std::string binary_stl(const TriangleMesh& mesh) {
  std::string text = "solid but binary";
  text.resize(80, ' ');
  append(text, static_cast<std::uint32_t>(mesh.triangles.size()), false);
  for (const Triangle& triangle : mesh.triangles) {
    text.append(12, '\0');
    for (const int vertex : triangle) {
      for (const double x : mesh.vertices[vertex]) {
        append(text, static_cast<float>(x), false);
      }
    }
    text.append(2, '\0');
  }
  return text;
}

const std::string ascii_stl =
    "  solid a\n facet normal -nan(ind) 0 1\n  OUTER LOOP\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1 0\n  "
    "endloop\n"
    " endfacet\nendsolid a\nsolid b\nfacet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 "
    "0\nendloop\n"
    "endfacet\nendsolid b\n";

TEST_F(ReadMesh, KeepsVerticesOfPly) {
  expect_hand_mesh(read_mesh(write("a.ply", hand_ply)));
  expect_hand_mesh(read_mesh(write("b.PLY", with_crlf(hand_ply))));
  expect_hand_mesh(read_mesh(write("c.ply", replaced(hand_ply, "0 0 0\n", "\n\n0 0 0\n"))));
  expect_hand_mesh(read_mesh(write("little.ply", binary_ply(false))));
  expect_hand_mesh(read_mesh(write("big.ply", binary_ply(true))));
  const std::string body = binary_ply(false);
  const std::size_t end = body.find("end_header\n") + 11;
  expect_hand_mesh(read_mesh(write("crlf.ply", with_crlf(body.substr(0, end)) + body.substr(end))));
}

TEST_F(ReadMesh, KeepsVerticesOfObj) {
  expect_hand_mesh(read_mesh(write("a.obj", hand_obj)));
  expect_hand_mesh(read_mesh(write("b.obj", with_crlf(hand_obj))));
  expect_hand_mesh(read_mesh(write("c.obj", replaced(hand_obj, "v 0 1 0\n", "\tv  +0 1e0 0 1 # w\n"))));
}

TEST_F(ReadMesh, KeepsVerticesOfOff) {
  expect_hand_mesh(read_mesh(write("a.off", hand_off)));
  expect_hand_mesh(read_mesh(write("b.off", with_crlf(hand_off))));
  expect_hand_mesh(read_mesh(write("c.off", "# c\n" + replaced(hand_off, "OFF\n6 3 0\n", "COFF 6 3\n# d\n\n"))));
  expect_hand_mesh(read_mesh(write("d.off", replaced(hand_off, "3 1 2 3\n", "3 1 2 3 255 0 0\n"))));
  expect_hand_mesh(read_mesh(write("e.off", replaced(hand_off, "OFF\n", ""))));
}

TEST_F(ReadMesh, StlHasAVertexForEachCorner) {
  const TriangleMesh text = read_mesh(write("a.stl", ascii_stl));
  ASSERT_EQ(text.vertices.size(), 6U);
  EXPECT_EQ(text.triangles, (std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}}));
  EXPECT_EQ(text.vertices[4], Vec3(1, 1, 0));
  const TriangleMesh box = make_box(Vec3(0.5, 0.25, 2), 2);
  const TriangleMesh binary = read_mesh(write("b.stl", binary_stl(box)));
  ASSERT_EQ(binary.triangles.size(), box.triangles.size());
  ASSERT_EQ(binary.vertices.size(), 3 * box.triangles.size());
  for (std::size_t t = 0; t < box.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(binary.vertices[binary.triangles[t][k]], box.vertices[box.triangles[t][k]]);
    }
  }
}

TEST_F(ReadMesh, ReadsOtherFormatsThroughAssimp) {
  // glTF with its buffer inside, one triangle under a node that moves and mirrors it.
  const std::string gltf =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],)"
      R"("nodes":[{"mesh":0,"translation":[10,0,0],"scale":[-1,1,1]}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":4}]}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;)"
      R"(base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
  const TriangleMesh mesh = read_mesh(write("a.gltf", gltf));
  ASSERT_EQ(mesh.vertices.size(), 3U);
  ASSERT_EQ(mesh.triangles.size(), 1U);
  const auto corner = [&](int k) { return mesh.vertices[mesh.triangles[0][k]]; };
  EXPECT_EQ(mesh.vertices[1], Vec3(9, 0, 0));
  // Mirroring turns a triangle over; its corners must follow for its front to stay in front.
  EXPECT_GT((corner(1) - corner(0)).cross(corner(2) - corner(0)).z(), 0);
  expect_refused("broken.gltf", "{\"asset\":", "assimp can't read it");
}

TEST_F(ReadMesh, SplitsConcavePolygonsRightWhereverTheyAre) {
  // An arrowhead, of which a fan from its first corner would cover more than there is; then a triangle.
  const std::vector<Vec3> corners = {{0, 2, 0}, {0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 0.5, 0}, {1, 3, 0}};
  struct Place {
    double size, offset;
  };
  for (const auto& [size, offset] : {Place{1, 0}, Place{1e-3, 0.5}, Place{1e-5, 600}}) {
    std::string off = "OFF\n6 2 0\n";
    for (const Vec3& corner : corners) {
      off += fmt::format("{} {} {}\n", offset + size * corner.x(), offset + size * corner.y(), offset);
    }
    // From each corner on, so that no fixed way of cutting is right by chance.
    for (const std::string face : {"0 1 2 3 4", "1 2 3 4 0", "2 3 4 0 1", "3 4 0 1 2", "4 0 1 2 3"}) {
      const TriangleMesh mesh = read_mesh(write("a.off", fmt::format("{}5 {}\n3 0 3 5\n", off, face)));
      ASSERT_EQ(mesh.vertices.size(), 6U);
      ASSERT_EQ(mesh.triangles.size(), 4U);
      EXPECT_EQ(mesh.triangles.back(), (Triangle{0, 3, 5}));
      TriangleMesh arrowhead = mesh;
      arrowhead.triangles.pop_back();
      EXPECT_NEAR(check_mesh(arrowhead).area_m2, 2.5 * size * size, 1e-6 * size * size) << face;
      EXPECT_EQ(check_mesh(arrowhead).inconsistent_edges, 0) << face;
    }
  }
}

TEST_F(ReadMesh, WhatIsWrittenComesBack) {
  TriangleMesh mesh = make_sphere(0.1, 2);
  for (Vec3& vertex : mesh.vertices) {
    vertex += Vec3(1.0 / 3, -7, 1e-9);
  }
  write_ply(mesh, path("a.ply"));
  const TriangleMesh back = read_mesh(path("a.ply"));
  EXPECT_EQ(back.vertices, mesh.vertices);
  EXPECT_EQ(back.triangles, mesh.triangles);
  EXPECT_FALSE(fs::exists(path("a.ply.part")));
}

TEST_F(ReadMesh, RefusesToWriteWhereItCannot) {
  const TriangleMesh mesh = make_sphere(0.1, 0);
  EXPECT_THROW(write_ply(mesh, path("no_folder") / "a.ply"), InputError);
  fs::create_directories(path("folder.ply") / "full");
  EXPECT_THROW(write_ply(mesh, path("folder.ply")), InputError);
  EXPECT_FALSE(fs::exists(path("folder.ply.part")));
}

TEST_F(ReadMesh, RefusesWhatIsNoMeshFile) {
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

TEST_F(ReadMesh, RefusesBinaryGarbage) {
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
    for (std::size_t place = 0; place < content.size(); ++place) {
      std::string bent = content;
      bent[place] = static_cast<char>(random() & 0xFFU);
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

TEST_F(ReadMesh, RefusesTruncatedFiles) {
  expect_refused("cut.ply", hand_ply.substr(0, hand_ply.find("0 1 0\n")), "ends after 3 of 6 elements 'vertex'");
  expect_refused("cut2.ply", binary_ply(false).substr(0, binary_ply(false).size() - 1), "ends after 5 of 6");
  expect_refused("cut.off", hand_off.substr(0, hand_off.find("4 4")), "ends after 1 of 3 faces");
  expect_refused("cut.stl", binary_stl(make_box(Vec3(1, 1, 1), 1)).substr(0, 300), "12 facets");
  expect_refused("cut2.stl", ascii_stl.substr(0, ascii_stl.find("endsolid")), "cut off");
  expect_refused("cut.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2", "line 5");
  expect_refused("cut2.obj", "v 0 0 0\nv 1 0 0\nv 0 1", "line 3");
  expect_refused("cut3.obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n", "only 2 vertices");
}

TEST_F(ReadMesh, RefusesIndicesOutOfRange) {
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

TEST_F(ReadMesh, RefusesVerticesThatAreNotFinite) {
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

TEST_F(ReadMesh, RefusesWhatHasNoSurface) {
  expect_refused("a.ply", replaced(hand_ply_header, "face 3", "face 0") + hand_coordinates, "no triangles");
  expect_refused("b.ply", hand_ply_header + hand_coordinates + "2 1 2\n1 0\n0\n", "no triangles");
  expect_refused("a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n3 0 0 1\n", "without area");
  expect_refused("b.off", "OFF\n5 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 0\n4 0 0\n5 0 1 2 3 4\n", "without area");
  expect_refused("c.off", "OFF\n0 0 0\n", "no triangles");
  expect_refused("a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n", "no triangles");
  expect_refused("a.stl", "solid a\nendsolid a\n", "no triangles");
  expect_refused("b.stl", binary_stl(TriangleMesh{}), "no triangles");
}

TEST_F(ReadMesh, RefusesPromisesThatNoFileCanKeep) {
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

TEST_F(ReadMesh, ReadsThePelvisAsItIs) {
  const auto folder = lhdl_folder();
  if (!folder) {
    GTEST_SKIP() << "LHDL data not found; set MUSCLEBENCH_DATA to their folder";
  }
  const fs::path file = *folder / "meshes" / "pelvis.ply";
  const TriangleMesh mesh = read_mesh(file);
  ASSERT_EQ(mesh.vertices.size(), 134964U);
  ASSERT_EQ(mesh.triangles.size(), 269974U);
  // The layout is known (three doubles; a byte and three ints), so the bytes can be compared without a reader.
  std::ifstream stream(file, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  const char* body = text.data() + text.find("end_header\n") + 11;
  for (const Vec3& vertex : mesh.vertices) {
    ASSERT_EQ(std::memcmp(body, vertex.data(), 24), 0);
    body += 24;
  }
  for (const Triangle& triangle : mesh.triangles) {
    ASSERT_EQ(std::memcmp(body + 1, triangle.data(), 12), 0);
    body += 13;
  }
}

}  // namespace
}  // namespace musclebench

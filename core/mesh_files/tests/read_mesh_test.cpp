#include "core/mesh_files/read_mesh.hpp"

#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/mesh/tests/lhdl_data.hpp"
#include "core/mesh_files/tests/mesh_files.hpp"
#include "core/mesh_repair/check_mesh.hpp"

namespace musclebench {
namespace {

using ReadMesh = MeshFiles;

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

/// glTF with its buffer inside, one triangle.
std::string gltf_with_nodes(const std::string& nodes) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[)" + nodes +
         R"(],)"
         R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":4}]}],)"
         R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],)"
         R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;)"
         R"(base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
}

TEST_F(ReadMesh, ReadsOtherFormatsThroughAssimp) {
  const std::string gltf = gltf_with_nodes(R"({"mesh":0,"translation":[10,0,0],"scale":[-1,1,1]})");
  const TriangleMesh mesh = read_mesh(write("a.gltf", gltf));
  ASSERT_EQ(mesh.vertices.size(), 3U);
  ASSERT_EQ(mesh.triangles.size(), 1U);
  const auto corner = [&](int k) { return mesh.vertices[mesh.triangles[0][k]]; };
  EXPECT_EQ(mesh.vertices[1], Vec3(9, 0, 0));
  // Mirroring turns a triangle over; its corners must follow for its front to stay in front.
  EXPECT_GT((corner(1) - corner(0)).cross(corner(2) - corner(0)).z(), 0);
  expect_refused("broken.gltf", "{\"asset\":", "assimp can't read it");
}

TEST_F(ReadMesh, NodesAreNestedOnlySoDeep) {
  const auto nested = [](int depth) {
    std::string nodes;
    for (int i = 1; i <= depth; ++i) {
      nodes += fmt::format(R"({{"children":[{}]}},)", i);
    }
    return gltf_with_nodes(nodes + R"({"mesh":0})");
  };
  EXPECT_EQ(read_mesh(write("a.gltf", nested(100))).triangles.size(), 1U);
  expect_refused("b.gltf", nested(400), "nests its nodes more than 256 deep");
}

TEST_F(ReadMesh, SplitsConcavePolygonsRightWhereverTheyAre) {
  // An arrowhead, of which a fan from its first corner would cover more than there is; then a triangle.
  const std::vector<Vec3> corners = {{0, 2, 0}, {0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 0.5, 0}, {1, 3, 0}};
  struct Placement {
    double size, offset;
  };
  for (const auto& [size, offset] : {Placement{1, 0}, Placement{1e-3, 0.5}, Placement{1e-5, 600}}) {
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

/// assimp 5.2.5 aborts on these: what it takes for blanks at the beginning of its data may be a coordinate's bytes.
TEST_F(ReadMesh, SplitsAPolygonWhereverItsFirstCornerIs) {
  const TriangleMesh mesh =
      read_mesh(write("a.off", "OFF\n5 2 0\n1 0 0\n1 0 0\n10 0 0\n0 1 0\n.5 .5 -1e5\n5 0 1 2 3 4\n3 2 3 4\n"));
  EXPECT_EQ(mesh.triangles.size(), 4U);
}

TEST_F(ReadMesh, SplitsAConvexPolygonIntoAFanAndCutsAHoleOut) {
  const TriangleMesh fan = read_mesh(write("a.off", "OFF\n5 1 0\n0 0 0\n2 0 0\n2 0 1\n1 0 2\n0 0 1\n5 0 1 2 3 4\n"));
  EXPECT_EQ(fan.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
  // A square of edge 4 with a square hole of edge 2, which a slit joins with the outside.
  const TriangleMesh ring = read_mesh(
      write("b.off", "OFF\n8 1 0\n0 0 0\n4 0 0\n4 4 0\n0 4 0\n1 1 0\n1 3 0\n3 3 0\n3 1 0\n10 0 1 2 3 0 4 5 6 7 4\n"));
  EXPECT_EQ(ring.triangles.size(), 8U);
  EXPECT_NEAR(check_mesh(ring).area_m2, 12, 1e-12);
}

TEST_F(ReadMesh, APolygonThatCannotBeCutBecomesAFan) {
  // A bow tie, all corners on a line, and all at one position; then a triangle.
  const TriangleMesh mesh = read_mesh(
      write("a.off", "OFF\n5 4 0\n0 0 0\n1 1 0\n1 0 0\n0 1 0\n2 2 0\n4 0 1 2 3\n4 0 1 4 1\n4 0 0 0 0\n3 0 2 3\n"));
  EXPECT_EQ(mesh.triangles,
            (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 4}, {0, 4, 1}, {0, 0, 0}, {0, 0, 0}, {0, 2, 3}}));
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

#include "core/mesh_repair/weld_mesh.hpp"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/mesh/mesh_edges.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh_repair/check_mesh.hpp"

namespace musclebench {
namespace {

/// Three vertices of its own for every triangle, as STL has them.
TriangleMesh soup_of(const TriangleMesh& mesh) {
  TriangleMesh soup;
  for (const Triangle& triangle : mesh.triangles) {
    const int first = static_cast<int>(soup.vertices.size());
    for (const int vertex : triangle) {
      soup.vertices.push_back(mesh.vertices[static_cast<std::size_t>(vertex)]);
    }
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

std::multiset<std::array<double, 3>> positions_of(const TriangleMesh& mesh) {
  std::multiset<std::array<double, 3>> positions;
  for (const Vec3& vertex : mesh.vertices) {
    positions.insert({vertex.x(), vertex.y(), vertex.z()});
  }
  return positions;
}

TEST(WeldMesh, ACleanMeshStaysAsItIs) {
  const TriangleMesh ball = make_sphere(0.01, 3);
  const WeldedMesh welded = weld_mesh(ball, "ball");
  EXPECT_EQ(welded.mesh.vertices, ball.vertices);
  EXPECT_EQ(welded.mesh.triangles, ball.triangles);
  EXPECT_TRUE(welded.changes.empty());
  for (std::size_t i = 0; i < ball.vertices.size(); ++i) {
    EXPECT_EQ(welded.welded_vertex[i], static_cast<int>(i));
  }
}

TEST(WeldMesh, ASoupOfTrianglesIsTheSameSurface) {
  const TriangleMesh ball = make_sphere(0.01, 3);
  const TriangleMesh soup = soup_of(ball);
  const WeldedMesh welded = weld_mesh(soup, "ball");
  EXPECT_EQ(positions_of(welded.mesh), positions_of(ball));
  EXPECT_EQ(welded.mesh.triangles.size(), ball.triangles.size());
  EXPECT_EQ(MeshEdges(welded.mesh).count(), MeshEdges(ball).count());
  const MeshReport report = check_mesh(welded.mesh);
  EXPECT_EQ(describe(report).front(), "no defects");
  EXPECT_NEAR(report.volume_m3, check_mesh(ball).volume_m3, 1e-20);
  ASSERT_EQ(welded.changes.size(), 1U);
  EXPECT_EQ(welded.changes[0], "merged 3198 vertices into an earlier one at the same position");
  for (std::size_t i = 0; i < soup.vertices.size(); ++i) {
    EXPECT_EQ(welded.mesh.vertices[static_cast<std::size_t>(welded.welded_vertex[i])], soup.vertices[i]);
  }
}

TEST(WeldMesh, UnusedVerticesAreLeftOutAndTheOthersKeepTheirOrder) {
  TriangleMesh ball = make_sphere(0.01, 1);
  const std::vector<Vec3> used = ball.vertices;
  ball.vertices.insert(ball.vertices.begin() + 3, Vec3(1, 2, 3));
  for (Triangle& triangle : ball.triangles) {
    for (int& vertex : triangle) {
      vertex += vertex >= 3 ? 1 : 0;
    }
  }
  const WeldedMesh welded = weld_mesh(ball, "ball");
  EXPECT_EQ(welded.mesh.vertices, used);
  EXPECT_EQ(welded.welded_vertex[2], 2);
  EXPECT_EQ(welded.welded_vertex[3], -1);
  EXPECT_EQ(welded.welded_vertex[4], 3);
  EXPECT_EQ(welded.changes, std::vector<std::string>{"dropped 1 vertex that no triangle uses"});
}

TEST(WeldMesh, WhatWeldingLeavesWithoutAreaOrTwiceGoes) {
  TriangleMesh ball = make_sphere(0.01, 1);
  const auto triangles = ball.triangles.size();
  const int copy = static_cast<int>(ball.vertices.size());
  ball.vertices.push_back(ball.vertices[static_cast<std::size_t>(ball.triangles[0][0])]);
  ball.triangles.push_back({ball.triangles[0][0], ball.triangles[0][1], copy});
  ball.triangles.push_back({copy, ball.triangles[0][1], ball.triangles[0][2]});
  const WeldedMesh welded = weld_mesh(ball, "ball");
  EXPECT_EQ(welded.mesh.triangles.size(), triangles);
  EXPECT_EQ(welded.changes.size(), 3U);
}

TEST(WeldMesh, TurnsWhatIsWoundInwards) {
  TriangleMesh ball = make_sphere(0.01, 2);
  for (Triangle& triangle : ball.triangles) {
    std::swap(triangle[0], triangle[1]);
  }
  const WeldedMesh welded = weld_mesh(ball, "ball");
  EXPECT_GT(check_mesh(welded.mesh).volume_m3, 0);
  EXPECT_EQ(welded.changes, std::vector<std::string>{"turned 1 surface from inwards to outwards"});
}

TEST(WeldMesh, OpenAndFlatMusclesAreAccepted) {
  TriangleMesh sheet;
  sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}};
  sheet.triangles = {{0, 1, 3}, {1, 2, 3}, {0, 2, 1}};  // the last one has no area
  EXPECT_EQ(weld_mesh(sheet, "sheet").mesh.triangles, sheet.triangles);
  sheet.triangles = {{0, 0, 1}};
  EXPECT_THROW((void)weld_mesh(sheet, "sheet"), InputError);
}

TEST(OrientSurfaces, ManyCavitiesKeepTheirSense) {
  TriangleMesh ball = make_sphere(0.1, 3);
  for (int i = 0; i < 8; ++i) {  // more than are asked about without a tree
    const TriangleMesh cavity = make_sphere(0.005, 1);
    const int first = static_cast<int>(ball.vertices.size());
    for (const Vec3& vertex : cavity.vertices) {
      ball.vertices.push_back(vertex + Vec3(0.012 * i - 0.04, 0, 0));
    }
    for (const Triangle& triangle : cavity.triangles) {
      ball.triangles.push_back({first + triangle[0], first + triangle[2], first + triangle[1]});
    }
  }
  EXPECT_EQ(weld_mesh(ball, "ball").mesh.triangles, ball.triangles);
}

}  // namespace
}  // namespace musclebench

#include "core/mesh_repair/repair_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/bvh/triangle_bvh.hpp"
#include "core/mesh/mesh_edges.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/tests/lhdl_data.hpp"
#include "core/mesh_files/read_mesh.hpp"
#include "core/mesh_repair/check_mesh.hpp"
#include "core/mesh_repair/tests/turned_triangle.hpp"

namespace musclebench {
namespace {

TriangleMesh inverted(TriangleMesh mesh) {
  std::for_each(mesh.triangles.begin(), mesh.triangles.end(), turn);
  return mesh;
}

TriangleMesh moved(TriangleMesh mesh, const Vec3& displacement) {
  for (Vec3& vertex : mesh.vertices) {
    vertex += displacement;
  }
  return mesh;
}

TriangleMesh joined(TriangleMesh mesh, const TriangleMesh& other) {
  const int shift = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& [a, b, c] : other.triangles) {
    mesh.triangles.push_back({a + shift, b + shift, c + shift});
  }
  return mesh;
}

/// Each triangle with vertices of its own, as STL has it.
TriangleMesh soup(const TriangleMesh& mesh) {
  TriangleMesh out;
  for (const Triangle& triangle : mesh.triangles) {
    const int first = static_cast<int>(out.vertices.size());
    for (const int vertex : triangle) {
      out.vertices.push_back(mesh.vertices[vertex]);
    }
    out.triangles.push_back({first, first + 1, first + 2});
  }
  return out;
}

double volume_m3(const TriangleMesh& mesh) { return check_mesh(mesh).volume_m3; }

bool has_change(const RepairedMesh& repaired, const std::string& line) {
  return std::find(repaired.changes.begin(), repaired.changes.end(), line) != repaired.changes.end();
}

void expect_refused(const TriangleMesh& mesh, const std::string& part) {
  try {
    repair_mesh(mesh, "bone");
    ADD_FAILURE() << "was accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find("bone: "), 0U) << error.what();
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST(RepairMesh, LeavesACleanMeshAsItIs) {
  for (const TriangleMesh& mesh : {make_sphere(0.02, 3), make_box(Vec3(1, 2, 3), 4), make_capsule(0.01, 0.1, 16)}) {
    const RepairedMesh repaired = repair_mesh(mesh, "bone");
    EXPECT_TRUE(repaired.clean);
    EXPECT_TRUE(repaired.changes.empty());
    EXPECT_EQ(repaired.mesh.vertices, mesh.vertices);
    EXPECT_EQ(repaired.mesh.triangles, mesh.triangles);
  }
}

TEST(RepairMesh, OnlyWhatNeedsNoRepairIsClean) {
  const TriangleMesh box = make_box({1, 2, 3}, 2);
  EXPECT_TRUE(is_clean(box));
  TriangleMesh open = box;
  open.triangles.pop_back();
  EXPECT_FALSE(is_clean(open));
  TriangleMesh inverted = box;
  for (Triangle& triangle : inverted.triangles) std::swap(triangle[1], triangle[2]);
  EXPECT_FALSE(is_clean(inverted));
  TriangleMesh loose = box;
  loose.vertices.emplace_back(0, 0, 0);
  EXPECT_FALSE(is_clean(loose));
  EXPECT_FALSE(is_clean({}));
}

TEST(RepairMesh, TurnsAnInvertedBoxOutwards) {
  const TriangleMesh box = make_box(Vec3(1, 2, 3), 3);
  const RepairedMesh repaired = repair_mesh(inverted(box), "bone");
  EXPECT_TRUE(repaired.clean);
  EXPECT_EQ(repaired.mesh.triangles, box.triangles);
  EXPECT_EQ(repaired.changes, std::vector<std::string>{"turned 1 surface from inwards to outwards"});
}

TEST(RepairMesh, WindsLikeTheMajorityWhateverTheScaleAndPlace) {
  for (const double scale : {std::ldexp(1, -10), 1.0, std::ldexp(1, 10)}) {
    TriangleMesh mesh = make_sphere(scale, 3);
    const TriangleMesh right = mesh;
    for (const int t : {0, 17, 300, 301, 302, 1279}) {
      turn(mesh.triangles[t]);
    }
    const RepairedMesh repaired = repair_mesh(moved(mesh, scale * Vec3(1024, 0, -512)), "bone");
    EXPECT_TRUE(repaired.clean);
    EXPECT_EQ(repaired.mesh.triangles, right.triangles);
    EXPECT_EQ(repaired.changes, std::vector<std::string>{"turned 6 triangles wound against the rest of the surface"});
  }
}

TEST(RepairMesh, JoinsASoupOfTriangles) {
  const TriangleMesh sphere = make_sphere(0.03, 3);
  const RepairedMesh repaired = repair_mesh(soup(sphere), "bone");
  EXPECT_TRUE(repaired.clean);
  EXPECT_EQ(repaired.mesh.vertices.size(), sphere.vertices.size());
  EXPECT_EQ(repaired.mesh.triangles.size(), sphere.triangles.size());
  EXPECT_DOUBLE_EQ(volume_m3(repaired.mesh), volume_m3(sphere));
}

TEST(RepairMesh, DropsLooseVerticesAndTrianglesOfTwoVertices) {
  TriangleMesh mesh = make_box(Vec3(1, 1, 1), 2);
  const TriangleMesh right = mesh;
  mesh.vertices.emplace_back(5, 5, 5);
  mesh.vertices.push_back(mesh.vertices[3]);
  mesh.triangles.push_back({0, 0, 1});
  mesh.triangles.push_back({3, static_cast<int>(mesh.vertices.size()) - 1, 7});
  const RepairedMesh repaired = repair_mesh(mesh, "bone");
  EXPECT_TRUE(repaired.clean);
  EXPECT_EQ(repaired.mesh.vertices, right.vertices);
  EXPECT_EQ(repaired.mesh.triangles, right.triangles);
  EXPECT_TRUE(has_change(repaired, "merged 1 vertex into an earlier one at the same position"));
  EXPECT_TRUE(has_change(repaired, "dropped 2 zero-area triangles"));
  EXPECT_TRUE(has_change(repaired, "dropped 1 vertex that no triangle uses"));
}

/// A box whose triangle `at` is cut in three at `share` of one side, the third one flat.
TriangleMesh with_flat_triangle(TriangleMesh mesh, int at, double share = 0.5) {
  const auto [a, b, c] = mesh.triangles[at];
  const int middle = static_cast<int>(mesh.vertices.size());
  mesh.vertices.emplace_back((1 - share) * mesh.vertices[a] + share * mesh.vertices[b]);
  mesh.triangles[at] = {a, middle, c};
  mesh.triangles.push_back({middle, b, c});
  mesh.triangles.push_back({a, b, middle});
  return mesh;
}

TEST(RepairMesh, TakesInFlatTrianglesWithoutTearing) {
  TriangleMesh mesh = make_box(Vec3(1, 1, 1), 2);
  for (const int at : {0, 11, 30}) {
    mesh = with_flat_triangle(mesh, at);
  }
  // A flat triangle behind a flat triangle: the second one appears only when the first is gone.
  mesh = with_flat_triangle(mesh, static_cast<int>(mesh.triangles.size()) - 1);
  ASSERT_EQ(check_mesh(mesh).boundary_edges, 0);
  ASSERT_GE(check_mesh(mesh).zero_area_triangles, 4);
  const RepairedMesh repaired = repair_mesh(mesh, "bone");
  EXPECT_TRUE(repaired.clean);
  for (const std::string& change : repaired.changes) {
    EXPECT_EQ(change.find("turned"), std::string::npos) << change;
  }
  const MeshReport report = check_mesh(repaired.mesh);
  EXPECT_EQ(describe(report).front(), "no defects");
  EXPECT_DOUBLE_EQ(report.volume_m3, 8);
  EXPECT_DOUBLE_EQ(report.area_m2, 24);
}

/// Without them there would be a slit in the surface.
TEST(RepairMesh, LeavesFlatTrianglesThatItCannotTakeIn) {
  TriangleMesh mesh = make_box(Vec3(1, 1, 1), 2);
  mesh = with_flat_triangle(mesh, 0);
  for (int i = 1; i < 60; ++i) {
    mesh = with_flat_triangle(mesh, static_cast<int>(mesh.triangles.size()) - 1, i / 64.0);
  }
  const RepairedMesh repaired = repair_mesh(mesh, "bone");
  EXPECT_EQ(check_mesh(repaired.mesh).boundary_edges, 0);
  EXPECT_GT(check_mesh(repaired.mesh).zero_area_triangles, 0);
  EXPECT_FALSE(repaired.clean);
}

TEST(RepairMesh, DropsALooseFlatTriangle) {
  TriangleMesh mesh = make_box(Vec3(1, 1, 1), 3);
  const int first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {Vec3(3, 3, 3), Vec3(4, 4, 4), Vec3(5, 5, 5)});
  mesh.triangles.push_back({first, first + 1, first + 2});
  const RepairedMesh repaired = repair_mesh(mesh, "bone");
  EXPECT_TRUE(repaired.clean);
  EXPECT_TRUE(has_change(repaired, "dropped 1 zero-area triangle"));
}

TEST(RepairMesh, DropsDoubledTrianglesOfEitherWinding) {
  const TriangleMesh box = make_box(Vec3(1, 1, 1), 3);
  for (const bool is_opposite : {false, true}) {
    for (const int doubled : {1, 2, 9, static_cast<int>(box.triangles.size()) - 1}) {
      TriangleMesh mesh = box;
      for (int t = 0; t < doubled; ++t) {
        const auto [a, b, c] = box.triangles[t];
        mesh.triangles.push_back(is_opposite ? Triangle{b, a, c} : Triangle{b, c, a});
      }
      const RepairedMesh repaired = repair_mesh(mesh, "bone");
      EXPECT_TRUE(repaired.clean) << doubled << is_opposite;
      EXPECT_EQ(repaired.mesh.triangles.size(), box.triangles.size());
      EXPECT_NEAR(volume_m3(repaired.mesh), 8, 1e-12);
    }
  }
  TriangleMesh twofold = box;
  twofold.triangles.insert(twofold.triangles.end(), box.triangles.begin(), box.triangles.end());
  EXPECT_EQ(repair_mesh(twofold, "bone").mesh.triangles, box.triangles);
  TriangleMesh threefold = twofold;
  threefold.triangles.insert(threefold.triangles.end(), box.triangles.begin(), box.triangles.end());
  EXPECT_EQ(repair_mesh(threefold, "bone").mesh.triangles, box.triangles);
}

/// A box with a triangle without thickness that stands out from one of its edges.
TriangleMesh box_with_fin(bool is_wound_right) {
  TriangleMesh mesh = make_box(Vec3(1, 1, 1), 3);
  const auto [a, b, c] = mesh.triangles[0];
  const int tip = static_cast<int>(mesh.vertices.size());
  mesh.vertices.emplace_back(3 * mesh.vertices[a]);
  mesh.triangles.push_back({a, b, tip});
  mesh.triangles.push_back(is_wound_right ? Triangle{b, a, tip} : Triangle{a, b, tip});
  return mesh;
}

TEST(RepairMesh, KeepsAFinAndIsNotCleanThen) {
  for (const bool is_wound_right : {true, false}) {
    const TriangleMesh mesh = box_with_fin(is_wound_right);
    const RepairedMesh repaired = repair_mesh(mesh, "bone");
    EXPECT_FALSE(repaired.clean);
    EXPECT_EQ(repaired.mesh.triangles.size(), mesh.triangles.size());
    EXPECT_TRUE(has_change(repaired, "left 1 non-manifold edge"));
    EXPECT_NEAR(volume_m3(repaired.mesh), 8, 1e-12);
    // The two sides of the fin cancel, so the winding number sees it from neither side.
    const TriangleBvh tree(repaired.mesh);
    const auto [i, j, k] = repaired.mesh.triangles.back();
    const Vec3 tip = repaired.mesh.vertices[k];
    const Vec3 normal = (repaired.mesh.vertices[i] - tip).cross(repaired.mesh.vertices[j] - tip).normalized();
    const Vec3 middle = (repaired.mesh.vertices[i] + repaired.mesh.vertices[j] + 4 * tip) / 6;
    EXPECT_NEAR(tree.winding_number(middle + 1e-3 * normal), 0, 0.1);
    EXPECT_NEAR(tree.winding_number(middle - 1e-3 * normal), 0, 0.1);
    EXPECT_NEAR(tree.winding_number(Vec3(0, 0, 0.1)), 1, 0.1);
  }
}

TEST(RepairMesh, OrientsSeparateSurfacesOneByOne) {
  const TriangleMesh ball = make_sphere(1, 2);
  const TriangleMesh apart = joined(ball, inverted(moved(ball, Vec3(3, 0, 0))));
  const RepairedMesh repaired = repair_mesh(apart, "bones");
  EXPECT_FALSE(repaired.clean) << "two components";
  EXPECT_NEAR(volume_m3(repaired.mesh), 2 * volume_m3(ball), 1e-12);
  EXPECT_TRUE(has_change(repaired, "turned 1 surface from inwards to outwards"));
  // Overlapping is not nested: the smaller one still has to point outwards by itself.
  const TriangleMesh overlapping = joined(ball, inverted(moved(make_sphere(0.5, 2), Vec3(0.8, 0, 0))));
  EXPECT_NEAR(volume_m3(repair_mesh(overlapping, "bones").mesh), 1.125 * volume_m3(ball), 1e-12);
}

/// A tetrahedron within the ball's bounding box, one corner of which is in the ball: the first that is asked about.
TEST(RepairMesh, ASurfaceWithOneCornerInAnotherIsNotNested) {
  const TriangleMesh ball = make_sphere(1, 3);
  TriangleMesh tetrahedron;
  tetrahedron.vertices = {{0.5, 0.5, 0.5}, {0.95, 0.6, 0.6}, {0.6, 0.95, 0.6}, {0.6, 0.6, 0.95}};
  tetrahedron.triangles = {{0, 1, 2}, {3, 1, 0}, {1, 3, 2}, {2, 3, 0}};
  ASSERT_LT(volume_m3(tetrahedron), 0);
  const RepairedMesh repaired = repair_mesh(joined(ball, tetrahedron), "bones");
  EXPECT_NEAR(volume_m3(repaired.mesh), volume_m3(ball) - volume_m3(tetrahedron), 1e-12);
}

TEST(RepairMesh, KeepsACavityAndTurnsItWithItsBone) {
  const TriangleMesh ball = make_sphere(1, 3);
  const TriangleMesh cavity = inverted(make_sphere(0.5, 2));
  const TriangleMesh core = make_sphere(0.2, 1);
  const TriangleMesh hollow = joined(joined(core, ball), cavity);
  const double solid_m3 = volume_m3(hollow);
  const RepairedMesh kept = repair_mesh(hollow, "bone");
  EXPECT_TRUE(kept.changes.empty());
  EXPECT_EQ(kept.mesh.triangles, hollow.triangles);
  const RepairedMesh turned = repair_mesh(inverted(hollow), "bone");
  EXPECT_EQ(turned.mesh.triangles, hollow.triangles);
  EXPECT_EQ(turned.changes, std::vector<std::string>{"turned 3 surfaces from inwards to outwards"});
  EXPECT_NEAR(volume_m3(turned.mesh), solid_m3, 1e-12);
}

TEST(RepairMesh, OrientsSurfacesThatShareAnEdgeOrAPointOneByOne) {
  const TriangleMesh box = make_box(Vec3(1, 1, 1), 2);
  const TriangleMesh at_edge = joined(box, inverted(moved(box, Vec3(2, 2, 0))));
  RepairedMesh repaired = repair_mesh(at_edge, "bones");
  EXPECT_FALSE(repaired.clean);
  EXPECT_TRUE(has_change(repaired, "left 2 non-manifold edges"));
  EXPECT_NEAR(volume_m3(repaired.mesh), 16, 1e-12);
  const TriangleMesh at_point = joined(box, inverted(moved(box, Vec3(2, 2, 2))));
  repaired = repair_mesh(at_point, "bones");
  EXPECT_FALSE(repaired.clean);
  EXPECT_TRUE(has_change(repaired, "left 1 non-manifold vertex"));
  EXPECT_NEAR(volume_m3(repaired.mesh), 16, 1e-12);
}

TEST(RepairMesh, ClosesHolesAndSaysSo) {
  TriangleMesh mesh = inverted(make_sphere(1, 4));
  const double whole_m3 = -volume_m3(mesh);
  // A hole of one triangle, and one of six around a vertex.
  std::erase_if(mesh.triangles, [](const Triangle& t) { return std::ranges::find(t, 100) != t.end(); });
  mesh.triangles.pop_back();
  const RepairedMesh repaired = repair_mesh(mesh, "bone");
  EXPECT_TRUE(repaired.clean);
  EXPECT_TRUE(repaired.known_closed);
  EXPECT_TRUE(has_change(repaired, "closed 2 holes (9 boundary edges)"));
  EXPECT_EQ(repaired.mesh.triangles.size(), mesh.triangles.size() + 7);
  EXPECT_NEAR(volume_m3(repaired.mesh), whole_m3, 1e-4);
  EXPECT_LT(volume_m3(repaired.mesh), whole_m3) << "a cap is flat";
}

/// Two triangles that share a vertex and nothing else, at many vertices: the rims are met in any order.
TEST(RepairMesh, ClosesHolesThatTouchAtAVertexOneByOne) {
  const TriangleMesh whole = make_sphere(1, 4);
  const auto has = [](const Triangle& triangle, int node) {
    return std::ranges::find(triangle, node) != triangle.end();
  };
  const auto count = static_cast<int>(whole.vertices.size());
  for (int vertex = count - 100; vertex < count; ++vertex) {
    const auto first = std::ranges::find_if(whole.triangles, [&](const Triangle& t) { return has(t, vertex); });
    const auto other = std::ranges::find_if(whole.triangles, [&](const Triangle& t) {
      return has(t, vertex) && std::ranges::count_if(t, [&](int node) { return has(*first, node); }) == 1;
    });
    ASSERT_NE(other, whole.triangles.end());
    TriangleMesh mesh = whole;
    std::erase_if(mesh.triangles, [&](const Triangle& t) { return t == *first || t == *other; });
    const RepairedMesh repaired = repair_mesh(mesh, "bone");
    EXPECT_TRUE(repaired.clean) << vertex;
    EXPECT_TRUE(has_change(repaired, "closed 2 holes (6 boundary edges)")) << vertex;
  }
}

TEST(RepairMesh, LeavesALooseTriangleOpen) {
  TriangleMesh mesh = make_sphere(1, 4);
  const auto first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {Vec3(3, 0, 0), Vec3(3, 0.1, 0), Vec3(3, 0, 0.1)});
  mesh.triangles.push_back({first, first + 1, first + 2});
  const RepairedMesh repaired = repair_mesh(mesh, "bone");
  EXPECT_FALSE(repaired.clean);
  EXPECT_TRUE(has_change(repaired, "left open: the surface has 3 boundary edges"));
}

TEST(RepairMesh, LeavesAHoleOpenWhoseRimIsNoLoop) {
  TriangleMesh mesh = make_sphere(1, 4);
  const Triangle first = mesh.triangles.front();
  const auto tip = static_cast<int>(mesh.vertices.size());
  mesh.vertices.emplace_back(0, 0, 2);
  mesh.triangles.push_back({first[1], first[0], tip});  // a fin
  const RepairedMesh repaired = repair_mesh(mesh, "bone");
  EXPECT_FALSE(repaired.clean);
  EXPECT_TRUE(has_change(repaired, "left open: the surface has 2 boundary edges"));
  EXPECT_EQ(repaired.mesh.triangles.size(), mesh.triangles.size());
}

TEST(RepairMesh, HolesChangeTheSideOfFewPoints) {
  TriangleMesh mesh = inverted(make_sphere(1, 4));
  const std::size_t count = mesh.triangles.size();
  for (const std::size_t t : {std::size_t{10}, count / 2, count - 10}) {
    mesh.triangles.erase(mesh.triangles.begin() + static_cast<long>(t));
  }
  const RepairedMesh repaired = repair_mesh(mesh, "bone");
  EXPECT_TRUE(has_change(repaired, "closed 3 holes (9 boundary edges)"));
  EXPECT_GT(volume_m3(repaired.mesh), 4);
  const TriangleBvh tree(repaired.mesh);
  int wrong = 0;
  int asked = 0;
  for (double x = -1.2; x < 1.2; x += 0.1) {
    for (double y = -1.2; y < 1.2; y += 0.1) {
      for (double z = -1.2; z < 1.2; z += 0.1) {
        const double radius = Vec3(x, y, z).norm();
        if (radius < 0.995 || radius > 1) {
          wrong += (tree.winding_number(Vec3(x, y, z)) > 0.5) != (radius < 1) ? 1 : 0;
          ++asked;
        }
      }
    }
  }
  EXPECT_LE(wrong, asked / 1000);
}

TEST(RepairMesh, RefusesWhatIsWideOpen) {
  TriangleMesh sieve = make_sphere(1, 3);
  std::size_t index = 0;
  std::erase_if(sieve.triangles, [&](const Triangle&) { return index++ % 20 == 0; });
  expect_refused(sieve, "boundary edges");
  // Half a fine sphere has few boundary edges, but no inside.
  TriangleMesh half = make_sphere(1, 6);
  std::erase_if(half.triangles, [&](const Triangle& t) { return half.vertices[t[0]].z() > 0; });
  const MeshReport report = check_mesh(half);
  ASSERT_LT(report.boundary_edges, 0.01 * 1.5 * report.triangles);
  expect_refused(half, "of its area");
}

TEST(RepairMesh, RefusesWhatHasNoSurface) {
  expect_refused(TriangleMesh{}, "no surface");
  TriangleMesh line;
  line.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)};
  line.triangles = {{0, 1, 2}, {0, 2, 1}, {0, 0, 1}};
  expect_refused(line, "no surface");
}

TEST(RepairMesh, MoebiusStripIsRefusedAndNothingHangs) {
  TriangleMesh strip;
  constexpr int segments = 40;
  for (int i = 0; i < segments; ++i) {
    const double turn_rad = 2 * std::numbers::pi * i / segments;
    for (const double side : {-0.2, 0.2}) {
      const double radius = 1 + side * std::cos(turn_rad / 2);
      strip.vertices.emplace_back(radius * std::cos(turn_rad), radius * std::sin(turn_rad),
                                  side * std::sin(turn_rad / 2));
    }
  }
  for (int i = 0; i < segments; ++i) {
    const bool is_last = i + 1 == segments;
    const int c = is_last ? 1 : 2 * i + 2;
    const int d = is_last ? 0 : 2 * i + 3;
    strip.triangles.push_back({2 * i, c, 2 * i + 1});
    strip.triangles.push_back({c, d, 2 * i + 1});
  }
  expect_refused(strip, "boundary edges");
}

class RepairLhdlMesh : public testing::Test {
 protected:
  void SetUp() override {
    if (!lhdl_folder()) {
      GTEST_SKIP() << "LHDL data not found; set MUSCLEBENCH_DATA to their folder";
    }
  }
  static TriangleMesh read(const std::string& name) { return read_mesh(*lhdl_folder() / "meshes" / (name + ".ply")); }
};

TEST_F(RepairLhdlMesh, FemurBecomesClean) {
  const RepairedMesh repaired = repair_mesh(read("femur_r"), "femur_r");
  EXPECT_TRUE(repaired.clean);
  EXPECT_EQ(repaired.changes, std::vector<std::string>{"turned 5 triangles wound against the rest of the surface"});
  EXPECT_EQ(describe(check_mesh(repaired.mesh)).front(), "no defects");
}

TEST_F(RepairLhdlMesh, InvertedFemurGivesTheSame) {
  const TriangleMesh femur = read("femur_r");
  const RepairedMesh repaired = repair_mesh(femur, "femur_r");
  EXPECT_EQ(repair_mesh(inverted(femur), "femur_r").mesh.triangles, repaired.mesh.triangles);
}

TEST_F(RepairLhdlMesh, PelvisIsClosedAndConsistentButNotClean) {
  const TriangleMesh pelvis = read("pelvis");
  const RepairedMesh repaired = repair_mesh(pelvis, "pelvis");
  EXPECT_FALSE(repaired.clean);
  EXPECT_TRUE(has_change(repaired, "merged 4 vertices into an earlier one at the same position"));
  EXPECT_TRUE(has_change(repaired, "dropped 10 zero-area triangles"));
  const MeshReport report = check_mesh(repaired.mesh);
  EXPECT_EQ(report.boundary_edges, 0);
  EXPECT_EQ(report.zero_area_triangles, 0);
  EXPECT_EQ(report.flipped_triangles, 0);
  EXPECT_EQ(report.components, 3);
  EXPECT_NEAR(report.volume_m3, check_mesh(pelvis).volume_m3, 1e-12);
  const MeshEdges edges(repaired.mesh);
  for (int edge = 0; edge < edges.count(); ++edge) {
    const auto uses = edges.uses(edge);
    const auto forward = std::count_if(uses.begin(), uses.end(), [](const EdgeUse& use) { return use.forward; });
    EXPECT_EQ(2 * forward, static_cast<long>(uses.size())) << "at edge " << edge;
  }
}

}  // namespace
}  // namespace musclebench

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/effects/effect_registry.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh_repair/repair_mesh.hpp"

namespace musclebench {
namespace {

/// A roof along y whose ridge, at z = 0, has a right angle.
TriangleMesh roof() {
  TriangleMesh mesh;
  for (const double y : {-0.1, 0.1}) {
    mesh.vertices.insert(mesh.vertices.end(), {{-0.05, y, -0.05}, {0.05, y, -0.05}, {0, y, 0}});
  }
  mesh.triangles = {{0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}};
  return mesh;
}

/// Depth in a roof that goes on forever downwards.
double depth_in_roof_m(const Vec3& at) { return (-at.z() - std::abs(at.x())) / std::sqrt(2); }

/// A sheet of 4 by 4 squares of 10 mm, whose nodes stand beside the ridge.
TriangleMesh sheet(double z_m) {
  TriangleMesh mesh;
  for (int i = 0; i <= 4; ++i) {
    for (int j = 0; j <= 4; ++j) mesh.vertices.emplace_back(0.01 * i - 0.025, 0.01 * j - 0.02, z_m);
  }
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      const int a = 5 * i + j;
      mesh.triangles.push_back({a, a + 5, a + 6});
      mesh.triangles.push_back({a, a + 6, a + 1});
    }
  }
  return mesh;
}

/// Lower side of a muscle.
TriangleMesh sheet_facing_down(double z_m) {
  TriangleMesh mesh = sheet(z_m);
  for (Triangle& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

double deepest_m(const TriangleMesh& mesh, const std::vector<Vec3>& nodes) {
  double deepest = -1;
  constexpr int parts = 50;
  for (const auto& [a, b, c] : mesh.triangles) {
    for (int i = 0; i <= parts; ++i) {
      for (int j = 0; i + j <= parts; ++j) {
        const double u = static_cast<double>(i) / parts;
        const double v = static_cast<double>(j) / parts;
        deepest = std::max(deepest, depth_in_roof_m((1 - u - v) * nodes[a] + u * nodes[b] + v * nodes[c]));
      }
    }
  }
  return deepest;
}

/// A pyramid whose tip, at the height of 0, points upwards and leans to the side.
TriangleMesh spike() {
  TriangleMesh mesh;
  mesh.vertices = {
      {-0.02, -0.02, -0.05}, {0.02, -0.02, -0.05}, {0.02, 0.02, -0.05}, {-0.02, 0.02, -0.05}, {0.001, 0.0002, 0}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  return mesh;
}

/// The tip of a tower 0.4 mm high and as wide, on a plate whose upper side is at z = 0.
const Vec3 tip(0.0013, 0.0021, 0.0004);

TriangleMesh plate_with_tower() {
  TriangleMesh mesh;
  for (const double z : {-0.01, 0.0}) {
    mesh.vertices.insert(mesh.vertices.end(), {{-0.05, -0.05, z}, {0.05, -0.05, z}, {0.05, 0.05, z}, {-0.05, 0.05, z}});
  }
  for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
    mesh.vertices.emplace_back(tip.x() + 0.0002 * x, tip.y() + 0.0002 * y, 0);
  }
  mesh.vertices.push_back(tip);
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
  for (int k = 0; k < 4; ++k) {
    const int next = (k + 1) % 4;
    for (const int below : {0, 4}) {  // the sides, and around the tower
      mesh.triangles.push_back({below + k, below + next, below + 4 + next});
      mesh.triangles.push_back({below + k, below + 4 + next, below + 4 + k});
    }
    mesh.triangles.push_back({8 + k, 8 + next, 12});
  }
  return mesh;
}

/// Height of a sheet, whose nodes have moved, above a point.
double height_m(const TriangleMesh& mesh, const std::vector<Vec3>& nodes, const Vec3& at) {
  for (const auto& [a, b, c] : mesh.triangles) {
    Mat3 corners;
    corners << nodes[a], nodes[b], nodes[c];
    corners.row(2).setOnes();
    const Vec3 weights = corners.inverse() * Vec3(at.x(), at.y(), 1);
    if (weights.minCoeff() >= 0) return weights.dot(Vec3(nodes[a].z(), nodes[b].z(), nodes[c].z())) - at.z();
  }
  return -1;
}

struct Lying {
  explicit Lying(TriangleMesh of, const std::map<std::string, ParameterValue>& given = {},
                 const TriangleMesh& on = roof())
      : mesh(std::move(of)), masses(mesh.vertices.size(), 1), start(mesh.vertices), predicted(mesh.vertices) {
    bones.push_back({"bone", repair_mesh(on, "bone")});
    parameters = given;
    free.resize(mesh.vertices.size());
    std::iota(free.begin(), free.end(), 0);
  }

  void make() {
    const EffectEntry* entry = find_effect("surface_contact");
    StageInput input{bones, mesh.vertices.size(), mesh.triangles, masses, bound, threads};
    input.contacts = contacts;
    input.make_surface_queries = make_queries;
    stage = entry->make_stage(input, Parameters(entry->parameters, parameters, "test"));
  }

  void step(int times = 1) {
    if (!stage) make();
    for (int i = 0; i < times; ++i) {
      (void)stage->after_bones({start, predicted, free, previous, poses, {}});
      previous = poses;
    }
  }

  TriangleMesh mesh;
  std::vector<double> masses;
  std::vector<Vec3> start;
  std::vector<Vec3> predicted;
  std::vector<BoundNode> bound;
  std::vector<int> free;
  std::vector<Bone> bones;
  std::vector<RigidMotion> poses = {RigidMotion{}};
  std::vector<RigidMotion> previous = {RigidMotion{}};
  std::map<std::string, ParameterValue> parameters;
  ContactProperties contacts;
  MakeSurfaceQueries make_queries;
  std::unique_ptr<ContactStage> stage;
  int threads = 1;
};

TEST(SurfaceContact, ARidgeBetweenTheNodesLiftsTheFaces) {
  Lying lying(sheet(-0.003));
  for (const Vec3& node : lying.predicted) ASSERT_LT(depth_in_roof_m(node), 0) << "no node is inside";
  ASSERT_NEAR(deepest_m(lying.mesh, lying.predicted), 0.003 / std::sqrt(2), 1e-5);
  lying.step(30);
  EXPECT_LT(deepest_m(lying.mesh, lying.predicted), 1e-4);
  EXPECT_EQ(lying.stage->name(), "surface_contact");
}

/// The signed distance of the roof's upper sides as planes that go on forever, by their formula.
class FormulaOfRoof final : public SurfaceQueries {
 public:
  [[nodiscard]] SurfaceAnswer locate(const Vec3& point, int /*near*/) const override {
    const Vec3 gradient = Vec3(point.x() < 0 ? -1 : 1, 0, 1).normalized();
    const double distance_m = -depth_in_roof_m(point);
    return {distance_m, gradient, point - distance_m * gradient, 7};
  }
  [[nodiscard]] Clearance clearance(const Vec3& point, int /*near*/) const override {
    return {std::abs(depth_in_roof_m(point)), 7};
  }
  [[nodiscard]] std::size_t bytes() const override { return 0; }
};

TEST(SurfaceContact, AsksTheQueriesThatItIsGiven) {
  Lying by_mesh(sheet(-0.003));
  by_mesh.step(30);
  Lying by_formula(sheet(-0.003));
  int made = 0;
  by_formula.make_queries = [&made](const Bone& /*bone*/, int /*threads*/) {
    ++made;
    return std::make_shared<FormulaOfRoof>();
  };
  by_formula.step(30);
  EXPECT_EQ(made, 1);
  EXPECT_LT(deepest_m(by_formula.mesh, by_formula.predicted), 1e-4);
  double apart_m = 0;
  for (std::size_t i = 0; i < by_mesh.predicted.size(); ++i) {
    apart_m = std::max(apart_m, (by_mesh.predicted[i] - by_formula.predicted[i]).norm());
  }
  EXPECT_LT(apart_m, 1e-5) << "the way out over the ridge is found by steps, to a millionth of what it may be";
}

TEST(SurfaceContact, ASpikeLiftsTheFaceAndDoesNotPushItAside) {
  Lying lying(sheet(-0.001), {}, spike());
  lying.step(30);
  double lifted_m = 0;
  double aside_m = 0;
  for (std::size_t i = 0; i < lying.predicted.size(); ++i) {
    const Vec3 moved = lying.predicted[i] - lying.mesh.vertices[i];
    lifted_m = std::max(lifted_m, moved.z());
    aside_m = std::max(aside_m, moved.head<2>().norm());
  }
  EXPECT_GT(lifted_m, 0.0009);
  EXPECT_LT(aside_m, 0.1 * lifted_m);
}

/// A wedge along y whose edge, at z = 0, is so sharp that its sides stand at 11 degrees to each other's mirror plane.
TriangleMesh sharp_wedge() {
  TriangleMesh mesh = roof();
  for (Vec3& vertex : mesh.vertices) vertex.x() *= 0.2;
  return mesh;
}

/// A leaning triangle stands with its lower edge across the wedge, between two nodes.
TEST(SurfaceContact, AnEdgeAcrossASharpRidgeIsLiftedAlongTheNormalOfBoth) {
  TriangleMesh leaning;
  leaning.vertices = {{-0.011, 0, -0.0005}, {0.009, 0, -0.0005}, {0, 0.02, 0.02}};
  leaning.triangles = {{0, 1, 2}};
  Lying lying(leaning, {}, sharp_wedge());
  lying.step(30);
  const Vec3 moved = 0.45 * lying.predicted[0] + 0.55 * lying.predicted[1] -
                     (0.45 * lying.mesh.vertices[0] + 0.55 * lying.mesh.vertices[1]);
  EXPECT_NEAR(moved.z(), 0.0005, 2e-5);
  EXPECT_LT(moved.head<2>().norm(), 0.02 * moved.z());
}

TEST(SurfaceContact, ATowerFarNarrowerThanAFaceLiftsIt) {
  Lying lying(sheet_facing_down(0.00015), {}, plate_with_tower());
  ASSERT_NEAR(height_m(lying.mesh, lying.predicted, tip), -0.00025, 1e-9);
  lying.step(30);
  EXPECT_GT(height_m(lying.mesh, lying.predicted, tip), -2e-5);
}

TEST(SurfaceContact, ATowerUnderTheMusclesOtherSideIsNotHeldAgainstIt) {
  Lying lying(sheet(0.00015), {}, plate_with_tower());
  lying.step(30);
  EXPECT_EQ(height_m(lying.mesh, lying.predicted, tip), height_m(lying.mesh, lying.mesh.vertices, tip));
}

TEST(SurfaceContact, ATowerThatSlidesUnderAFaceIsFollowedBetweenSearches) {
  Lying lying(sheet_facing_down(0.00015), {{"interval", std::int64_t{1000}}}, plate_with_tower());
  lying.step(10);
  lying.poses[0] = RigidMotion{Mat3::Identity(), Vec3(0, -0.006, 0)};
  const Vec3 moved = tip + lying.poses[0].translation_m;
  ASSERT_LT(height_m(lying.mesh, lying.predicted, moved), -5e-5);
  lying.step(30);
  EXPECT_GT(height_m(lying.mesh, lying.predicted, moved), -2e-5);
}

/// Between its nodes a sheet comes down on the ridge by 1 mm and slides along it by 4 mm.
TEST(SurfaceContact, FacesRubOnTheBone) {
  const auto slide_m = [](double coefficient) {
    Lying lying(sheet(0));
    lying.contacts.friction_coefficient = coefficient;
    for (Vec3& node : lying.predicted) node += Vec3(0, 0.004, -0.001);
    lying.step();
    double on_ridge_m = 0;  // of the nodes beside the ridge
    for (std::size_t i = 12; i <= 17; i += 5) on_ridge_m += (lying.predicted[i] - lying.start[i]).y() / 2;
    return on_ridge_m;
  };
  EXPECT_EQ(slide_m(0), 0.004);
  EXPECT_LT(slide_m(0.5), 0.0037);
  EXPECT_GT(slide_m(0.5), 0.0033);
  EXPECT_LT(std::abs(slide_m(100)), 0.0008);
}

TEST(SurfaceContact, FacesKeepTheMarginFromTheBone) {
  Lying lying(sheet(0.0005));
  lying.contacts.margin_m = 0.001;
  lying.step(30);
  double ridge_m = 1;
  for (int i = 0; i <= 10; ++i) {
    ridge_m = std::min(ridge_m, height_m(lying.mesh, lying.predicted, Vec3(0.0001, 0.003 * i - 0.015, 0)));
  }
  EXPECT_NEAR(ridge_m, 0.001, 5e-5);
}

TEST(SurfaceContact, NoBitDependsOnTheThreads) {
  const auto lifted = [](int threads) {
    Lying lying(sheet(-0.003));
    lying.threads = threads;
    lying.step(7);
    return lying.predicted;
  };
  EXPECT_EQ(lifted(1), lifted(3));
}

TEST(SurfaceContact, WhatTouchesNothingIsLeftToTheBit) {
  Lying lying(sheet(0.001));
  lying.step(10);
  EXPECT_EQ(lying.predicted, lying.mesh.vertices);
  EXPECT_EQ(lying.stage->contact_count(), 0);
}

TEST(SurfaceContact, TheCacheSeesASheetThatFallsAndOneThatGrows) {
  Lying falling(sheet(0.03));
  falling.step(5);
  for (int i = 0; i < 33; ++i) {
    for (Vec3& node : falling.predicted) node.z() -= 0.001;
    falling.start = falling.predicted;
    falling.step(1);
  }
  falling.step(30);
  EXPECT_LT(deepest_m(falling.mesh, falling.predicted), 1e-4);

  // Of a sheet that stands beside the roof one row of nodes is drawn over the ridge.
  Lying growing(sheet(-0.003));
  for (Vec3& node : growing.predicted) node.x() += 0.08;
  growing.start = growing.predicted;
  growing.step(5);
  for (std::size_t i = 0; i < 5; ++i) growing.predicted[i].x() = -0.025;
  growing.start = growing.predicted;
  growing.step(60);
  EXPECT_LT(deepest_m(growing.mesh, growing.predicted), 1e-4);
}

TEST(SurfaceContact, PlanesMoveWithTheirBoneBetweenSearches) {
  Lying lying(sheet(0.0001), {{"interval", std::int64_t{1000}}});
  lying.step();
  lying.poses[0] = RigidMotion{Mat3::Identity(), Vec3(0, 0, 0.002)};
  lying.step(10);
  std::vector<Vec3> in_bone = lying.predicted;
  for (Vec3& node : in_bone) node.z() -= 0.002;
  EXPECT_LT(deepest_m(lying.mesh, in_bone), 1e-4);
}

TEST(SurfaceContact, DepthAtTheStartGivesNoVelocity) {
  Lying lying(sheet(-0.003));
  lying.step();
  double moved_m = 0;
  for (std::size_t i = 0; i < lying.predicted.size(); ++i) {
    EXPECT_LT((lying.predicted[i] - lying.start[i]).norm(), 1e-15) << i;
    moved_m = std::max(moved_m, (lying.predicted[i] - lying.mesh.vertices[i]).norm());
  }
  EXPECT_GT(moved_m, 1e-4);
}

TEST(SurfaceContact, HeldNodesStayAndWhatIsAttachedToTheBoneIsLeftInIt) {
  Lying held(sheet(-0.003));
  for (std::size_t i = 0; i < 10; ++i) held.masses[i] = 0;
  held.step(60);
  for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(held.predicted[i], held.mesh.vertices[i]);
  EXPECT_LT(deepest_m(held.mesh, held.predicted), 2e-4);

  Lying attached(sheet(-0.003));
  for (int i = 10; i < 15; ++i) {
    attached.masses[static_cast<std::size_t>(i)] = 0;
    attached.bound.push_back({i, 0});
  }
  attached.step(10);
  EXPECT_EQ(attached.predicted, attached.mesh.vertices);
}

}  // namespace
}  // namespace musclebench

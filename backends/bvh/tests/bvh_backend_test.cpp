// Beyond the contract suite: non-manifold surfaces, features, points far away, threads.
#include "backends/bvh/bvh_backend.hpp"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "backends/bvh/exact_surface.hpp"
#include "core/base/random_numbers.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

std::vector<Contact> detect(const std::vector<Bone>& bones, const std::vector<Vec3>& points, int threads = 1,
                            const std::vector<RigidMotion>& poses = {}) {
  const auto backend = make_bvh_backend(Parameters(bvh_entry().parameters, {}, "test"));
  const TriangleMesh no_muscle;
  backend->build(bones, no_muscle, threads);
  backend->update(poses.empty() ? std::vector<RigidMotion>(bones.size()) : poses, points);
  std::vector<int> nodes(points.size());
  std::iota(nodes.begin(), nodes.end(), 0);
  std::vector<Contact> contacts;
  backend->detect(points, nodes, contacts);
  return contacts;
}

void append(TriangleMesh& mesh, const TriangleMesh& other, const Vec3& by, bool turned = false) {
  const auto first = static_cast<int>(mesh.vertices.size());
  for (const Vec3& vertex : other.vertices) {
    mesh.vertices.emplace_back(vertex + by);
  }
  for (Triangle t : other.triangles) {
    if (turned) {
      std::swap(t[1], t[2]);
    }
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
}

std::vector<Vec3> random_points(const Vec3& half_extents, int count, std::uint64_t seed) {
  RandomNumbers random(seed);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double x = 2 * random.share() - 1;
    const double y = 2 * random.share() - 1;
    points.emplace_back(half_extents.cwiseProduct(Vec3(x, y, 2 * random.share() - 1)));
  }
  return points;
}

/// A cube from -1 to 1 with a doubled triangle that stands on it without thickness, its tip at (0.5, 0, 2).
TriangleMesh cube_with_fin() {
  TriangleMesh mesh = make_box({1, 1, 1}, 2);
  int middle = -1;
  int side = -1;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    middle = mesh.vertices[v] == Vec3(0, 0, 1) ? static_cast<int>(v) : middle;
    side = mesh.vertices[v] == Vec3(1, 0, 1) ? static_cast<int>(v) : side;
  }
  const auto tip = static_cast<int>(mesh.vertices.size());
  mesh.vertices.emplace_back(0.5, 0, 2);
  mesh.triangles.push_back({middle, side, tip});
  mesh.triangles.push_back({side, middle, tip});
  return mesh;
}

TEST(BvhBackend, NothingIsInsideAFinAndItIsTheNearestSurfaceOfNothingElse) {
  const std::vector<Bone> bones = {{"fin", repair_mesh(cube_with_fin(), "fin")}};
  ASSERT_FALSE(bones[0].surface.clean);
  for (const double off : {0.0, 1e-15, 1e-9, 1e-3, 0.3}) {
    const std::vector<Vec3> about_fin = {{0.5, off, 1.5},   {0.5, -off, 1.5},  {0.5, off, 2},
                                         {0.5 + off, 0, 2}, {0.5, 0, 2 + off}, {0.3, off, 1.4}};
    EXPECT_TRUE(detect(bones, about_fin).empty()) << off;
  }
  const std::vector<Contact> below = detect(bones, {{0.5, 0, 1 - 1e-6}, {0.5, 0.25, 0.9}, {0.5, 0, 0.9}});
  ASSERT_EQ(below.size(), 3U);
  EXPECT_NEAR(below[0].depth_m, 1e-6, 1e-15);
  for (const Contact& contact : below) {
    EXPECT_LT((contact.normal - Vec3::UnitZ()).norm(), 1e-9);
  }
}

TEST(BvhBackend, PointsAtFacesEdgesAndVertices) {
  const TriangleMesh box = make_box({0.02, 0.03, 0.025}, 3);
  const std::vector<Bone> bones = {{"box", repair_mesh(box, "box")}};
  ASSERT_TRUE(bones[0].surface.clean);
  std::vector<Vec3> features = box.vertices;
  for (const auto& [a, b, c] : box.triangles) {
    const Vec3 &p = box.vertices[a], &q = box.vertices[b], &r = box.vertices[c];
    features.insert(features.end(), {(p + q) / 2, (q + r) / 2, (r + p) / 2, (p + q + r) / 3});
  }
  for (const double share : {1e-3, 1e-6, 1e-9, 1e-11}) {
    std::vector<Vec3> inner;
    std::vector<Vec3> outer;
    for (const Vec3& feature : features) {
      inner.emplace_back((1 - share) * feature);
      outer.emplace_back((1 + share) * feature);
    }
    EXPECT_TRUE(detect(bones, outer).empty()) << share;
    const std::vector<Contact> contacts = detect(bones, inner);
    ASSERT_EQ(contacts.size(), inner.size()) << share;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const Vec3 to_faces = Vec3(0.02, 0.03, 0.025) - inner[i].cwiseAbs();
      EXPECT_NEAR(contacts[i].depth_m, to_faces.minCoeff(), 1e-16);
      EXPECT_NEAR(contacts[i].normal.norm(), 1, 1e-12);
      EXPECT_GT(contacts[i].normal.dot(inner[i]), 0) << inner[i].transpose();
    }
  }
  // On the surface is outside.
  std::vector<Vec3> touching = features;
  for (const Vec3& feature : features) {
    touching.emplace_back((1 - 1e-13) * feature);
  }
  EXPECT_TRUE(detect(bones, touching).empty());
}

TEST(BvhBackend, ABoneFarFromTheOriginLosesNoDigits) {
  // Powers of two, so that moving the mesh rounds nothing.
  for (const double away_m : {0.0, 0x1p10, 0x1p20}) {
    TriangleMesh box = make_box({0x1p-5, 0x1p-5, 0x1p-4}, 4);
    std::vector<Vec3> points;
    for (const Vec3& point : random_points({0x1p-6, 0x1p-6, 0x1p-6}, 200, 1)) {
      points.emplace_back((point * 0x1p20).array().round() * 0x1p-20 + away_m);
    }
    for (Vec3& vertex : box.vertices) {
      vertex.array() += away_m;
    }
    const std::vector<Contact> contacts = detect({{"box", repair_mesh(box, "box")}}, points);
    ASSERT_EQ(contacts.size(), points.size());
    for (const Contact& contact : contacts) {
      const Vec3 local = points[contact.node] - Vec3::Constant(away_m);
      EXPECT_EQ(contact.depth_m, (Vec3(0x1p-5, 0x1p-5, 0x1p-4) - local.cwiseAbs()).minCoeff()) << away_m;
    }
  }
}

TEST(BvhBackend, TrianglesWithoutAreaChangeNothing) {
  TriangleMesh sphere = make_sphere(0.03, 3);
  const std::vector<Vec3> points = random_points({0.035, 0.035, 0.035}, 2000, 2);
  const std::vector<Contact> clean = detect({{"sphere", {sphere, true, {}}}}, points);
  for (int t = 0; t < 50; ++t) {
    const auto [a, b, c] = sphere.triangles[static_cast<std::size_t>(7 * t)];
    sphere.triangles.push_back({a, b, b});
    sphere.triangles.push_back({c, c, c});
  }
  const std::vector<Contact> degenerate = detect({{"sphere", {sphere, false, {}}}}, points);
  ASSERT_GT(clean.size(), 500U);
  ASSERT_EQ(clean.size(), degenerate.size());
  for (std::size_t i = 0; i < clean.size(); ++i) {
    EXPECT_EQ(clean[i].node, degenerate[i].node);
    EXPECT_EQ(clean[i].depth_m, degenerate[i].depth_m);
    EXPECT_EQ(clean[i].normal, degenerate[i].normal);
  }
}

TEST(BvhBackend, OverlapsAreInsideAndCavitiesAreOutside) {
  TriangleMesh mesh = make_sphere(1, 4);
  append(mesh, make_sphere(1, 4), {1, 0, 0});
  append(mesh, make_sphere(0.25, 3), {-0.5, 0, 0}, true);
  const std::vector<Bone> bones = {{"blob", {mesh, false, {}}}};
  const std::vector<Vec3> points = random_points({2.2, 1.2, 1.2}, 4000, 3);
  const std::vector<Contact> contacts = detect(bones, points);
  auto next = contacts.begin();
  int inside = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double to_union = std::min(points[i].norm(), (points[i] - Vec3(1, 0, 0)).norm()) - 1;
    const double to_cavity = 0.25 - (points[i] + Vec3(0.5, 0, 0)).norm();
    const double distance = std::max(to_union, to_cavity);
    const bool found = next != contacts.end() && next->node == static_cast<int>(i);
    next += found ? 1 : 0;
    if (std::abs(distance) > 0.01) {  // more than the spheres' faceting
      EXPECT_EQ(found, distance < 0) << points[i].transpose();
    }
    inside += distance < 0 ? 1 : 0;
  }
  EXPECT_GT(inside, 500);
}

TEST(BvhBackend, AnOpenSurfaceHasAnInsideBeyondItsHole) {
  TriangleMesh box = make_box({1, 1, 1}, 16);
  box.triangles.pop_back();
  const std::vector<Bone> bones = {{"box", {box, false, {}}}};  // `repair_mesh` would close it
  const std::vector<Contact> contacts = detect(bones, {{0, 0, 0}, {0.9, 0.9, 0.9}, {1.1, 0, 0}, {3, 3, 3}});
  ASSERT_EQ(contacts.size(), 2U);
  EXPECT_NEAR(contacts[0].depth_m, 1, 1e-12);
  EXPECT_NEAR(contacts[1].depth_m, 0.1, 1e-12);
}

TEST(BvhBackend, AnyNumberOfThreadsGivesTheSameBits) {
  const std::vector<Bone> bones = {{"ball", repair_mesh(make_sphere(1, 4), "ball")},
                                   {"fin", repair_mesh(cube_with_fin(), "fin")}};
  const std::vector<RigidMotion> poses = {RigidMotion::about_axis(Vec3::UnitX(), Vec3::Zero(), 0.3),
                                          RigidMotion::about_axis(Vec3::UnitZ(), Vec3(1, 0, 0), -0.7)};
  const std::vector<Vec3> points = random_points({1.5, 1.5, 2.2}, 5000, 4);
  const std::vector<Contact> alone = detect(bones, points, 1, poses);
  ASSERT_GT(alone.size(), 1000U);
  for (const int threads : {2, 3, 8}) {
    const std::vector<Contact> shared = detect(bones, points, threads, poses);
    ASSERT_EQ(shared.size(), alone.size());
    for (std::size_t i = 0; i < alone.size(); ++i) {
      EXPECT_EQ(shared[i].bone, alone[i].bone);
      EXPECT_EQ(shared[i].node, alone[i].node);
      EXPECT_EQ(shared[i].depth_m, alone[i].depth_m);
      EXPECT_EQ(shared[i].normal, alone[i].normal);
    }
  }
}

TEST(ExactSurface, ContainsWhereItsSignedDistanceIsNegative) {
  for (const TriangleMesh& mesh : {make_box({1, 1, 1}, 3), cube_with_fin()}) {
    const ExactSurface surface({"mesh", repair_mesh(mesh, "mesh")}, 1);
    int inside = 0;
    for (const Vec3& point : random_points({1.5, 1.5, 2.2}, 1000, 5)) {
      const double distance_m = surface.signed_distance_m(point);
      const ClosestPoint closest = surface.closest(point, -1);
      double clearance_m = 0;
      ASSERT_EQ(surface.side(point, closest).inside, distance_m < 0) << point.transpose();
      EXPECT_EQ(closest.distance_m, std::abs(distance_m));
      if (surface.is_outside(point, clearance_m)) {
        EXPECT_GE(distance_m, clearance_m);
      }
      inside += distance_m < 0 ? 1 : 0;
    }
    EXPECT_GT(inside, 100);
  }
}

TEST(BvhBackend, CountsTheBytesOfItsTrees) {
  const auto backend = make_bvh_backend(Parameters(bvh_entry().parameters, {}, "test"));
  const TriangleMesh no_muscle;
  std::vector<std::size_t> bytes;
  for (const int subdivisions : {2, 4}) {
    const std::vector<Bone> bones = {{"ball", repair_mesh(make_sphere(1, subdivisions), "ball")}};
    backend->build(bones, no_muscle, 1);
    bytes.push_back(backend->structure_bytes());
    // Corners, leaf indices, clusters, boxes, pseudo-normals.
    EXPECT_GT(bytes.back(), bones[0].surface.mesh.triangles.size() * 9 * sizeof(double));
  }
  EXPECT_NEAR(static_cast<double>(bytes[1]) / static_cast<double>(bytes[0]), 16, 2);
}

}  // namespace
}  // namespace musclebench

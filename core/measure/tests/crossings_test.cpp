#include "core/measure/crossings.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/referee/referee_sign.hpp"
#include "core/referee/tests/test_bones.hpp"

namespace musclebench {
namespace {

TEST(SelfCrossings, SoundShapesHaveNone) {
  for (const TriangleMesh& mesh : {make_sphere(0.1, 3), make_box({1, 2, 3}, 6), make_capsule(0.1, 0.3, 12)}) {
    EXPECT_EQ(count_self_crossings(mesh), 0);
  }
  EXPECT_EQ(count_self_crossings({}), 0);
}

TEST(SelfCrossings, BothTrianglesCountOnce) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, -1}, {0.2, 0.2, 1}, {0.3, 0.2, 1}, {5, 5, 5}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}, {2, 1, 6}};
  EXPECT_EQ(count_self_crossings(mesh), 2);
  mesh.triangles.push_back({5, 4, 3});  // the same from behind: it shares three vertices with the second
  EXPECT_EQ(count_self_crossings(mesh), 3);
}

TEST(SelfCrossings, NeighboursThatShareAVertexMayFoldThroughEachOther) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.4, 0.2, -1}, {0.2, 0.4, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  EXPECT_EQ(count_self_crossings(mesh), 2);
  mesh.vertices[4] = {0.2, 0.4, 0};  // it touches
  EXPECT_EQ(count_self_crossings(mesh), 0);
  mesh.vertices[3] = {0.4, 0.2, 0.1};  // on one side
  EXPECT_EQ(count_self_crossings(mesh), 0);
}

TEST(SelfCrossings, LikeEveryPairTriedOnAFoldedSheet) {
  // A sphere pushed through itself: its upper cap below its lower one.
  TriangleMesh folded = make_sphere(1, 3);
  for (Vec3& p : folded.vertices) {
    if (p.z() > 0.5) p.z() -= 1.8;
  }
  const int found = count_self_crossings(folded);
  EXPECT_GT(found, 20);
  EXPECT_LT(found, 600);
  EXPECT_EQ(count_self_crossings(moved(folded, some_motion())), found);
}

/// Triangles of the first surface that pass through one of the second: every one against every other.
int counted_one_by_one(const TriangleMesh& one, const TriangleMesh& other, const std::vector<char>& counts) {
  const auto corners = [](const TriangleMesh& mesh, const Triangle& t) {
    return TriangleCorners{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
  };
  int found = 0;
  for (std::size_t t = 0; t < one.triangles.size(); ++t) {
    found += counts[t] != 0 && std::ranges::any_of(other.triangles, [&](const Triangle& face) {
               return pass_through_each_other(corners(one, one.triangles[t]), corners(other, face));
             });
  }
  return found;
}

/// Two balls that overlap, the first bent through itself, and two bones: a ridge and a ball that has turned.
struct SeveralSurfaces {
  std::vector<Bone> bones{bone_of(make_roof(0.5, 0.6, 3)), bone_of(make_sphere(0.4, 2))};
  std::vector<RigidMotion> poses{RigidMotion{Mat3::Identity(), Vec3(0.7, 0, -0.3)},
                                 some_motion() * RigidMotion{Mat3::Identity(), Vec3(0.1, 0, 0)}};
  TriangleMesh muscles;
  std::vector<Body> bodies;
  std::vector<int> carriers;

  SeveralSurfaces() {
    TriangleMesh bent = make_sphere(1, 3);
    for (Vec3& p : bent.vertices) p.z() -= p.z() > 0.5 ? 1.3 : 0;
    add("bent", bent);
    add("ball", moved(make_sphere(0.7, 2), Vec3(1.2, 0.1, 0)));
    poses[1].translation_m = Vec3(0.9, 0.2, 0.1);
    carriers.assign(muscles.vertices.size(), -1);
  }
  void add(const std::string& name, const TriangleMesh& mesh) {
    const std::size_t first_node = muscles.vertices.size(), first_triangle = muscles.triangles.size();
    append(muscles, mesh);
    bodies.push_back({name, static_cast<int>(first_node), static_cast<int>(muscles.vertices.size()), first_triangle,
                      muscles.triangles.size()});
  }
  [[nodiscard]] TriangleMesh mesh_of(int body) const {
    const Body& of = bodies[static_cast<std::size_t>(body)];
    const auto begin = muscles.triangles.begin();
    return {muscles.vertices,
            {begin + static_cast<std::ptrdiff_t>(of.first_triangle),
             begin + static_cast<std::ptrdiff_t>(of.last_triangle)}};
  }
  [[nodiscard]] std::vector<int> counted(const CrossingMeter& made) const {
    CrossingMeter meter = made;
    RefereeTree tree(TriangleMesh{std::vector<Vec3>(muscles.vertices.size(), Vec3(1, 2, 3)), muscles.triangles});
    tree.refit(muscles.triangles, muscles.vertices);
    return meter.count(Referee(bones, 0), tree, poses, muscles.vertices);
  }
};

TEST(Crossings, LikeEveryPairTriedByPair) {
  SeveralSurfaces all;
  for (int node = 0; node < 40; ++node) all.carriers[static_cast<std::size_t>(7 * node)] = node % 2;
  const CrossingMeter meter(all.bones, all.muscles, all.bodies, all.carriers);
  const std::vector<int> found = all.counted(meter);
  ASSERT_EQ(found.size(), 7U);  // two bones, the other, itself; two bones, itself
  int left_out = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const CrossingPair& pair = meter.pairs()[i];
    const TriangleMesh muscle = all.mesh_of(pair.muscle);
    std::vector<char> counts(muscle.triangles.size(), 1);
    int expected = 0;
    if (pair.kind == CrossedSurface::bone) {
      for (std::size_t t = 0; t < counts.size(); ++t) {
        const auto carrier = [&](int node) { return all.carriers[static_cast<std::size_t>(node)]; };
        const Triangle& nodes = muscle.triangles[t];
        if (std::ranges::any_of(nodes, [&](int node) { return carrier(node) == pair.other; })) counts[t] = 0;
        if (std::ranges::all_of(nodes, [&](int node) { return carrier(node) >= 0; })) counts[t] = 0;
      }
      const auto bone = static_cast<std::size_t>(pair.other);
      TriangleMesh at_bone = muscle;
      for (Vec3& p : at_bone.vertices) p = all.poses[bone].apply_inverse(p);
      expected = counted_one_by_one(at_bone, all.bones[bone].surface.mesh, counts);
      EXPECT_EQ(pair.left_out, std::ranges::count(counts, 0));
      left_out += pair.left_out;
    } else {
      expected = counted_one_by_one(muscle, all.mesh_of(pair.other), counts);
    }
    EXPECT_EQ(found[i], expected) << "pair " << i;
    EXPECT_EQ(expected > 3, i != 6) << "pair " << i << ": only the second ball is sound by itself";
  }
  EXPECT_GT(left_out, 20);
  const CrossingSums sums = sums_of(meter.pairs(), found);
  EXPECT_EQ(sums.in_bones, found[0] + found[1] + found[4] + found[5]);
  EXPECT_EQ(sums.in_muscles, found[2]);
  EXPECT_EQ(sums.in_itself, found[3] + found[6]);
}

TEST(Crossings, AreExcusedWhereTheyWereAtRestAndNotElsewhere) {
  // A bar that a second muscle, or a bone, slides along.
  TriangleMesh muscles = make_box({1, 0.4, 0.2}, 12);
  const TriangleMesh ball = make_sphere(0.3, 2);
  const std::size_t bar_nodes = muscles.vertices.size(), bar_triangles = muscles.triangles.size();
  append(muscles, ball);
  const std::vector<Body> bodies{{"bar", 0, static_cast<int>(bar_nodes), 0, bar_triangles},
                                 {"ball", static_cast<int>(bar_nodes), static_cast<int>(muscles.vertices.size()),
                                  bar_triangles, muscles.triangles.size()}};
  const std::vector<Bone> bones{bone_of(ball)};
  const Referee referee(bones, 0);
  CrossingMeter meter(bones, muscles, bodies, std::vector<int>(muscles.vertices.size(), -1));
  RefereeTree tree(muscles);
  const auto count = [&](double bone_x, double ball_x) {
    std::vector<Vec3> positions = muscles.vertices;
    for (std::size_t i = bar_nodes; i < positions.size(); ++i) positions[i] += Vec3(ball_x, 0.0123, -0.3);
    tree.refit(muscles.triangles, positions);
    const RigidMotion pose{Mat3::Identity(), Vec3(bone_x, -0.0071, 0.3)};
    return meter.count(referee, tree, std::span(&pose, 1), positions);
  };
  const std::vector<int> at_rest = count(-0.5, 0.5);
  ASSERT_EQ(at_rest.size(), 5U);  // bar and bone, bar and ball, bar; ball and bone, ball
  ASSERT_GT(std::min(at_rest[0], at_rest[1]), 10);
  EXPECT_EQ(meter.beyond_rest(), at_rest) << "nothing is excused yet";
  meter.take_as_rest();
  EXPECT_EQ(meter.beyond_rest(), std::vector<int>(5, 0));
  count(-0.499, 0.501);
  EXPECT_EQ(meter.beyond_rest(), std::vector<int>(5, 0)) << "what stays there may shift a little";
  const std::vector<int> elsewhere = count(0.5, -0.5);
  EXPECT_LE(std::max(elsewhere[0] - at_rest[0], elsewhere[1] - at_rest[1]), 3) << "no more than at rest";
  EXPECT_EQ(meter.beyond_rest(), elsewhere);
}

TEST(SharedFaces, AreThoseOfTwoMusclesCornerByCorner) {
  SeveralSurfaces all;
  all.add("twin of ball", moved(make_sphere(0.7, 2), Vec3(1.2, 0.1, 0)));
  const std::vector<SharedFaces> shared = shared_faces(all.muscles, all.bodies);
  ASSERT_EQ(shared.size(), 1U);
  EXPECT_EQ(shared[0].muscle, 1);
  EXPECT_EQ(shared[0].other, 2);
  EXPECT_EQ(shared[0].triangles, 320);
}

TEST(Crossings, WhatOnlyTouchesDoesNotPass) {
  // Two boxes face on face, of the same triangles; and an edge that lies on a face.
  const TriangleMesh box = make_box({1, 1, 1}, 3);
  for (const Vec3& shift : {Vec3(2, 0, 0), Vec3(2, 0.5, 0.25), Vec3(2, 2, 0), Vec3(0, 0, 0)}) {
    const Body all{"box", 0, static_cast<int>(box.vertices.size()), 0, box.triangles.size()};
    const std::vector<Bone> bones{bone_of(moved(box, shift))};
    CrossingMeter meter(bones, box, std::span(&all, 1), std::vector<int>(box.vertices.size(), -1));
    const RigidMotion rest;
    EXPECT_EQ(meter.count(Referee(bones, 0), RefereeTree(box), std::span(&rest, 1), box.vertices),
              (std::vector<int>{0, 0}));
    EXPECT_GT(meter.last_work(), 0);
    std::vector<Vec3> deeper = box.vertices;
    for (Vec3& p : deeper) p += Vec3(0x1p-40, 0x1p-41, 0x1p-42);
    RefereeTree tree(box);
    tree.refit(box.triangles, deeper);
    if (shift.y() != 2) {
      EXPECT_GT(meter.count(Referee(bones, 0), tree, std::span(&rest, 1), deeper)[0], 5);
    }
  }
}

}  // namespace
}  // namespace musclebench

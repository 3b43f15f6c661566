// The contract of CollisionBackend, tested on all backends. A bug found in one adds a case for all.
#include "backends/tests/contract.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {
namespace {

TEST_P(Contract, AnalyticShapesWithinTheDeclaredBound) {
  for (const AnalyticBone& shape : analytic_bones()) {
    const std::vector<Bone> bones = one_bone(shape);
    const TriangleMesh mesh = muscle();
    const auto backend = build(GetParam(), bones, mesh);
    const AnswerBound bound = backend->answer_bound(0);
    const Answer answer = keys(detect(*backend, {RigidMotion{}}, mesh.vertices, all_nodes(mesh)));
    int inside = 0;
    for (const int node : all_nodes(mesh)) {
      const double d = shape.signed_distance_m(mesh.vertices[node]);
      inside += d < 0 ? 1 : 0;
      if (d < -bound.missed_depth_m - shape.faceting_m) {
        EXPECT_TRUE(answer.count({0, node})) << shape.name << " node " << node << " d " << d;
      }
      if (d > bound.false_distance_m + shape.faceting_m) {
        EXPECT_FALSE(answer.count({0, node})) << shape.name << " node " << node << " d " << d;
      }
    }
    EXPECT_GT(inside, 20) << shape.name;
    EXPECT_EQ(!answer.empty(), collides()) << shape.name;
  }
}

TEST_P(Contract, AgreesWithBruteForceWithinTheDeclaredBound) {
  for (const AnalyticBone& shape : analytic_bones()) {
    const std::vector<Bone> bones = one_bone(shape);
    const TriangleMesh mesh = muscle();
    const std::vector<Vec3> positions = moved(mesh.vertices, tilted);
    const auto backend = build(GetParam(), bones, mesh);
    const auto truth_backend = build("brute_force", bones, mesh);
    const AnswerBound bound = backend->answer_bound(0);
    const Answer answer = keys(detect(*backend, {tilted}, positions, all_nodes(mesh)));
    const std::vector<Contact> truth = detect(*truth_backend, {tilted}, positions, all_nodes(mesh));
    ASSERT_GT(truth.size(), 20U);
    for (const Contact& contact : truth) {
      if (contact.depth_m > bound.missed_depth_m + 1e-12) {
        EXPECT_TRUE(answer.count({0, contact.node})) << shape.name << " depth " << contact.depth_m;
      }
    }
    const Answer true_answer = keys(truth);
    for (const auto& [bone, node] : answer) {
      if (!true_answer.count({bone, node})) {
        EXPECT_LE(shape.signed_distance_m(mesh.vertices[node]), bound.false_distance_m + shape.faceting_m)
            << shape.name;
      }
    }
  }
}

TEST_P(Contract, DepthAndNormalPointTheShortestWayOut) {
  for (const AnalyticBone& shape : analytic_bones()) {
    const std::vector<Bone> bones = one_bone(shape);
    const TriangleMesh mesh = muscle();
    const auto backend = build(GetParam(), bones, mesh);
    if (!backend->capabilities().depth) {
      for (const Contact& contact : detect(*backend, {RigidMotion{}}, mesh.vertices, all_nodes(mesh))) {
        EXPECT_EQ(contact.depth_m, 0);
        EXPECT_EQ(contact.normal, Vec3(0, 0, 0));
      }
      continue;
    }
    const std::vector<Vec3> positions = moved(mesh.vertices, tilted);
    for (const Contact& contact : detect(*backend, {tilted}, positions, all_nodes(mesh))) {
      EXPECT_GE(contact.depth_m, 0);
      EXPECT_NEAR(contact.normal.norm(), 1, 1e-9);
      if (backend->capabilities().point_queries) {
        const double tolerance = backend->answer_bound(0).missed_depth_m + shape.faceting_m + 1e-12;
        EXPECT_NEAR(contact.depth_m, -shape.signed_distance_m(mesh.vertices[contact.node]), tolerance) << shape.name;
        const Vec3 out = tilted.apply_inverse(positions[contact.node] + contact.depth_m * contact.normal);
        EXPECT_NEAR(shape.signed_distance_m(out), 0, tolerance) << shape.name;
      }
    }
  }
}

TEST_P(Contract, EmptyWhenApart) {
  const AnalyticBone shape = analytic_bones().front();
  const std::vector<Bone> bones = one_bone(shape);
  const TriangleMesh mesh = muscle();
  const auto backend = build(GetParam(), bones, mesh);
  for (const double gap_m : {0.01, 1.0, 1e6}) {
    const RigidMotion away{Mat3::Identity(), Vec3(gap_m + 0.02, 0, 0)};
    EXPECT_TRUE(detect(*backend, {RigidMotion{}}, moved(mesh.vertices, away), all_nodes(mesh)).empty()) << gap_m;
  }
}

/// What is pruned by this would be missed.
TEST_P(Contract, NoContactIsFartherFromTheBonesBoxThanItsDeclaredReach) {
  for (const AnalyticBone& shape : analytic_bones()) {
    const std::vector<Bone> bones = one_bone(shape);
    const TriangleMesh mesh = muscle();
    const auto backend = build(GetParam(), bones, mesh);
    if (!backend->capabilities().point_queries) continue;
    const double reach_m = backend->contact_reach_m(bones.front());
    const Eigen::AlignedBox3d box = bounding_box(bones.front().surface.mesh.vertices);
    for (const double scale : {0.9, 1.0, 1.1, 1.5, 3.0}) {
      std::vector<Vec3> positions = mesh.vertices;
      for (Vec3& position : positions) position = box.center() + scale * (position - box.center());
      for (const Contact& contact : detect(*backend, {RigidMotion{}}, positions, all_nodes(mesh))) {
        EXPECT_LE(box.exteriorDistance(positions[static_cast<std::size_t>(contact.node)]), reach_m) << shape.name;
      }
    }
  }
}

TEST_P(Contract, TheSameAnswerTwice) {
  const std::vector<Bone> bones = one_bone(analytic_bones()[1]);
  const TriangleMesh mesh = muscle();
  const auto backend = build(GetParam(), bones, mesh);
  const auto again = build(GetParam(), bones, mesh, 2);
  const auto first = detect(*backend, {tilted}, moved(mesh.vertices, tilted), all_nodes(mesh));
  const auto second = detect(*backend, {tilted}, moved(mesh.vertices, tilted), all_nodes(mesh));
  const auto rebuilt = detect(*again, {tilted}, moved(mesh.vertices, tilted), all_nodes(mesh));
  for (const auto& other : {second, rebuilt}) {
    ASSERT_EQ(first.size(), other.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(first[i].node, other[i].node);
      EXPECT_EQ(first[i].depth_m, other[i].depth_m);
      EXPECT_EQ(first[i].normal, other[i].normal);
    }
  }
}

TEST_P(Contract, RigidMotionOfEverythingMovesTheAnswer) {
  const AnalyticBone shape = analytic_bones()[2];
  const std::vector<Bone> bones = one_bone(shape);
  const TriangleMesh mesh = muscle();
  const auto backend = build(GetParam(), bones, mesh);
  const auto at_rest = detect(*backend, {RigidMotion{}}, mesh.vertices, all_nodes(mesh));
  const auto elsewhere = detect(*backend, {tilted}, moved(mesh.vertices, tilted), all_nodes(mesh));
  ASSERT_EQ(at_rest.size(), elsewhere.size());
  for (std::size_t i = 0; i < at_rest.size(); ++i) {
    EXPECT_EQ(at_rest[i].node, elsewhere[i].node);
    EXPECT_NEAR(at_rest[i].depth_m, elsewhere[i].depth_m, 1e-9 * 0.1);
    EXPECT_LT((tilted.apply_to_direction(at_rest[i].normal) - elsewhere[i].normal).norm(), 1e-6);
  }
}

TEST_P(Contract, PermutedVerticesGiveTheSameSet) {
  const std::vector<Bone> bones = one_bone(analytic_bones()[0]);
  const TriangleMesh mesh = muscle();
  std::vector<int> new_index = all_nodes(mesh);
  std::shuffle(new_index.begin(), new_index.end(), std::mt19937(7));
  TriangleMesh permuted = mesh;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    permuted.vertices[new_index[i]] = mesh.vertices[i];
  }
  for (Triangle& triangle : permuted.triangles) {
    for (int& corner : triangle) {
      corner = new_index[corner];
    }
  }
  const auto backend = build(GetParam(), bones, mesh);
  const auto backend_permuted = build(GetParam(), bones, permuted);
  Answer expected;
  for (const auto& [bone, node] : keys(detect(*backend, {RigidMotion{}}, mesh.vertices, all_nodes(mesh)))) {
    expected.insert({bone, new_index[node]});
  }
  EXPECT_EQ(keys(detect(*backend_permuted, {RigidMotion{}}, permuted.vertices, all_nodes(mesh))), expected);
}

TEST_P(Contract, OrderedByBoneThenNodeAndOnlyWhatWasAsked) {
  std::vector<Bone> bones = one_bone(analytic_bones()[0]);
  bones.push_back(one_bone(analytic_bones()[1]).front());
  const TriangleMesh mesh = muscle();
  const auto backend = build(GetParam(), bones, mesh);
  const std::vector<RigidMotion> poses(2);
  const auto all = detect(*backend, poses, mesh.vertices, all_nodes(mesh));
  std::vector<int> some;
  for (const int node : all_nodes(mesh)) {
    if (node % 3 == 0) {
      some.push_back(node);
    }
  }
  const auto subset = detect(*backend, poses, mesh.vertices, some);
  const auto before = [](const Contact& a, const Contact& b) {
    return a.bone != b.bone ? a.bone < b.bone : a.node < b.node;
  };
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end(), before));
  Answer expected;
  for (const auto& key : keys(all)) {
    if (key.second % 3 == 0) {
      expected.insert(key);
    }
  }
  EXPECT_EQ(keys(all).size(), all.size());
  EXPECT_EQ(keys(subset), expected);
  EXPECT_EQ(keys(all).count({1, all.empty() ? -1 : all.back().node}), all.empty() ? 0U : 1U);
}

TEST_P(Contract, NoNodesNoContactsAndNonFiniteNodesAreFree) {
  const std::vector<Bone> bones = one_bone(analytic_bones()[0]);
  TriangleMesh mesh = muscle();
  const auto backend = build(GetParam(), bones, mesh);
  EXPECT_TRUE(detect(*backend, {RigidMotion{}}, mesh.vertices, {}).empty());
  if (backend->capabilities().point_queries) {
    mesh.vertices[5] = Vec3::Constant(std::nan(""));
    mesh.vertices[6] = Vec3::Constant(INFINITY);
    EXPECT_TRUE(detect(*backend, {RigidMotion{}}, mesh.vertices, {5, 6}).empty());
  }
}

/// A response that moves a node by its depth has done its work: what is on the surface, to rounding, is not inside.
TEST_P(Contract, OnTheWayOutANodeIsFree) {
  constexpr double exact_m = 1e-9;
  const BackendEntry& entry = find_backend(GetParam());
  for (const AnalyticBone& shape : analytic_bones()) {
    const std::vector<Bone> bones = one_bone(shape);
    const TriangleMesh mesh = muscle();
    const auto backend = entry.make(Parameters(entry.parameters, {}, "test"));
    backend->build(bones, mesh, 1);
    if (!collides() || !backend->capabilities().depth || backend->answer_bound(0).missed_depth_m > exact_m) {
      GTEST_SKIP() << GetParam() << " is not exact";
    }
    std::vector<Vec3> positions = moved(mesh.vertices, tilted);
    const std::vector<Contact> contacts = detect(*backend, {tilted}, positions, all_nodes(mesh));
    ASSERT_GT(contacts.size(), 20U);
    std::vector<int> nodes;
    for (const Contact& contact : contacts) {
      positions[static_cast<std::size_t>(contact.node)] += contact.depth_m * contact.normal;
      nodes.push_back(contact.node);
    }
    EXPECT_TRUE(detect(*backend, {tilted}, positions, nodes).empty()) << shape.name;
  }
}

/// Capabilities hold: responses are paired with backends by them.
TEST_P(Contract, CapabilitiesAreWhatItCanDo) {
  const std::vector<Bone> bones = one_bone(analytic_bones()[0]);
  const TriangleMesh mesh = muscle();
  const auto backend = build(GetParam(), bones, mesh);
  EXPECT_EQ(backend->capabilities().has_step, backend->step_m(0) > 0);
  EXPECT_EQ(lacks_for(find_backend(GetParam()).default_response, backend->capabilities()), "");
}

/// Switches of how a library is driven: they change its time, and no contact.
TEST_P(Contract, HowItIsDrivenChangesNoBit) {
  const BackendEntry& entry = find_backend(GetParam());
  const std::vector<Bone> bones = one_bone(analytic_bones()[2]);
  const TriangleMesh mesh = muscle();
  const std::vector<Vec3> positions = moved(mesh.vertices, tilted);
  bool has_any = false;
  for (const std::string name : {"cull", "warm_start", "accelerate"}) {
    if (find_parameter(entry.parameters, name) == nullptr) continue;
    has_any = true;
    std::map<bool, std::vector<Contact>> contacts;
    for (const bool value : {false, true}) {
      const auto backend = entry.make(Parameters(entry.parameters, {{name, value}}, "test"));
      backend->build(bones, mesh, 1);
      detect(*backend, {tilted}, moved(positions, {Mat3::Identity(), Vec3(1e-3, 0, 0)}), all_nodes(mesh));
      contacts[value] = detect(*backend, {tilted}, positions, all_nodes(mesh));
      EXPECT_GT(contacts[value].size(), 20U);
    }
    expect_same_bits(contacts[true], contacts[false]);
  }
  if (!has_any) GTEST_SKIP() << GetParam() << " has no such switch";
}

/// A row that calls itself exact drives recordings and judges others.
TEST_P(Contract, AnExactRowErrsByRoundingAndTellsSignedDistances) {
  const BackendEntry& entry = find_backend(GetParam());
  if (!entry.exact) {
    GTEST_SKIP() << entry.name << " does not call itself exact";
  }
  for (const AnalyticBone& shape : analytic_bones()) {
    const std::vector<Bone> bones = one_bone(shape);
    const TriangleMesh mesh = muscle();
    const AnswerBound bound = build(GetParam(), bones, mesh)->answer_bound(0);
    EXPECT_LT(bound.missed_depth_m, 1e-9);
    EXPECT_LT(bound.false_distance_m, 1e-9);
    ASSERT_TRUE(entry.signed_distance);
    const SignedDistance distance = entry.signed_distance(bones[0], 1);
    for (const Vec3& point : mesh.vertices) {
      EXPECT_NEAR(distance(point), shape.signed_distance_m(point), shape.faceting_m + 1e-12) << shape.name;
    }
  }
}

std::vector<std::string> backend_names() {
  std::vector<std::string> names;
  for (const BackendEntry& entry : backend_registry()) {
    names.push_back(entry.name);
  }
  return names;
}

INSTANTIATE_TEST_SUITE_P(Backends, Contract, testing::ValuesIn(backend_names()),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace musclebench

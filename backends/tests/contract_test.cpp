// What every backend promises, tested on all of them. A bug found in one adds a case for all.
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "core/geometry/shapes.hpp"

namespace musclebench {
namespace {

using Answer = std::set<std::pair<int, int>>;  // bone, node

Answer keys(const std::vector<Contact>& contacts) {
  Answer answer;
  for (const Contact& contact : contacts) {
    answer.insert({contact.bone, contact.node});
  }
  return answer;
}

/// A bone with a signed distance that a formula gives.
struct AnalyticBone {
  std::string name;
  TriangleMesh mesh;
  double (*signed_distance_m)(const Vec3&);
  double faceting_m;  ///< distance of the mesh from the shape that the formula means
};

constexpr double sphere_radius_m = 0.025;
constexpr double capsule_radius_m = 0.012;
constexpr double capsule_half_length_m = 0.02;
const Vec3 box_half_m(0.02, 0.03, 0.025);

std::vector<AnalyticBone> analytic_bones() {
  return {{"sphere", make_sphere(sphere_radius_m, 4), [](const Vec3& x) { return x.norm() - sphere_radius_m; }, 6e-5},
          {"box", make_box(box_half_m, 4),
           [](const Vec3& x) {
             const Vec3 q = x.cwiseAbs() - box_half_m;
             return q.cwiseMax(0).norm() + std::min(0.0, q.maxCoeff());
           },
           1e-15},
          {"capsule", make_capsule(capsule_radius_m, capsule_half_length_m, 64),
           [](const Vec3& x) {
             const double z = std::clamp(x.z(), -capsule_half_length_m, capsule_half_length_m);
             return (x - Vec3(0, 0, z)).norm() - capsule_radius_m;
           },
           3e-5}};
}

/// A muscle that the bone cuts into: a sphere whose surface runs through the origin.
TriangleMesh muscle() {
  TriangleMesh mesh = make_sphere(0.03, 3);
  for (Vec3& x : mesh.vertices) {
    x += Vec3(0.034, 0.006, -0.004);
  }
  return mesh;
}

std::vector<int> all_nodes(const TriangleMesh& mesh) {
  std::vector<int> nodes(mesh.vertices.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    nodes[i] = static_cast<int>(i);
  }
  return nodes;
}

std::vector<Vec3> moved(const std::vector<Vec3>& points, const RigidMotion& motion) {
  std::vector<Vec3> result;
  for (const Vec3& point : points) {
    result.push_back(motion.apply(point));
  }
  return result;
}

void expect_same_bits(const std::vector<Contact>& found, const std::vector<Contact>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].bone, expected[i].bone);
    ASSERT_EQ(found[i].node, expected[i].node);
    ASSERT_EQ(found[i].depth_m, expected[i].depth_m);
    ASSERT_EQ(found[i].normal, expected[i].normal);
  }
}

class Contract : public testing::TestWithParam<std::string> {
 public:
  std::unique_ptr<CollisionBackend> build(const std::string& name, const std::vector<Bone>& bones,
                                          const TriangleMesh& muscle_mesh, int threads = 1) {
    const BackendEntry& entry = find_backend(name);
    auto backend = entry.make(Parameters(entry.parameters, {}, "test"));
    backend->build(bones, muscle_mesh, threads);
    return backend;
  }

  static std::vector<Contact> ask(CollisionBackend& backend, const std::vector<RigidMotion>& poses,
                                  const std::vector<Vec3>& positions, const std::vector<int>& nodes) {
    std::vector<Contact> contacts;
    backend.update(poses, positions);
    backend.detect(positions, nodes, contacts);
    return contacts;
  }

  [[nodiscard]] bool collides() const { return GetParam() != "null"; }
};

std::vector<Bone> one_bone(const AnalyticBone& bone) { return {{bone.name, repair_mesh(bone.mesh, bone.name)}}; }

const RigidMotion tilted = RigidMotion::about_axis(Vec3(1, 2, -0.5).normalized(), Vec3(0.01, -0.02, 0.005), 0.9) *
                           RigidMotion{Mat3::Identity(), Vec3(0.3, -0.1, 0.2)};

TEST_P(Contract, AnalyticShapesWithinTheDeclaredBound) {
  for (const AnalyticBone& shape : analytic_bones()) {
    const std::vector<Bone> bones = one_bone(shape);
    const TriangleMesh mesh = muscle();
    const auto backend = build(GetParam(), bones, mesh);
    const AnswerBound bound = backend->answer_bound(0);
    const Answer answer = keys(ask(*backend, {RigidMotion{}}, mesh.vertices, all_nodes(mesh)));
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
    const Answer answer = keys(ask(*backend, {tilted}, positions, all_nodes(mesh)));
    const std::vector<Contact> truth = ask(*truth_backend, {tilted}, positions, all_nodes(mesh));
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
      for (const Contact& contact : ask(*backend, {RigidMotion{}}, mesh.vertices, all_nodes(mesh))) {
        EXPECT_EQ(contact.depth_m, 0);
        EXPECT_EQ(contact.normal, Vec3(0, 0, 0));
      }
      continue;
    }
    const std::vector<Vec3> positions = moved(mesh.vertices, tilted);
    for (const Contact& contact : ask(*backend, {tilted}, positions, all_nodes(mesh))) {
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
    EXPECT_TRUE(ask(*backend, {RigidMotion{}}, moved(mesh.vertices, away), all_nodes(mesh)).empty()) << gap_m;
  }
}

TEST_P(Contract, TheSameAnswerTwice) {
  const std::vector<Bone> bones = one_bone(analytic_bones()[1]);
  const TriangleMesh mesh = muscle();
  const auto backend = build(GetParam(), bones, mesh);
  const auto again = build(GetParam(), bones, mesh, 2);
  const auto first = ask(*backend, {tilted}, moved(mesh.vertices, tilted), all_nodes(mesh));
  const auto second = ask(*backend, {tilted}, moved(mesh.vertices, tilted), all_nodes(mesh));
  const auto rebuilt = ask(*again, {tilted}, moved(mesh.vertices, tilted), all_nodes(mesh));
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
  const auto at_rest = ask(*backend, {RigidMotion{}}, mesh.vertices, all_nodes(mesh));
  const auto elsewhere = ask(*backend, {tilted}, moved(mesh.vertices, tilted), all_nodes(mesh));
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
  std::vector<int> new_place = all_nodes(mesh);
  std::shuffle(new_place.begin(), new_place.end(), std::mt19937(7));
  TriangleMesh permuted = mesh;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    permuted.vertices[new_place[i]] = mesh.vertices[i];
  }
  for (Triangle& triangle : permuted.triangles) {
    for (int& corner : triangle) {
      corner = new_place[corner];
    }
  }
  const auto backend = build(GetParam(), bones, mesh);
  const auto backend_permuted = build(GetParam(), bones, permuted);
  Answer expected;
  for (const auto& [bone, node] : keys(ask(*backend, {RigidMotion{}}, mesh.vertices, all_nodes(mesh)))) {
    expected.insert({bone, new_place[node]});
  }
  EXPECT_EQ(keys(ask(*backend_permuted, {RigidMotion{}}, permuted.vertices, all_nodes(mesh))), expected);
}

TEST_P(Contract, OrderedByBoneThenNodeAndOnlyWhatWasAsked) {
  std::vector<Bone> bones = one_bone(analytic_bones()[0]);
  bones.push_back(one_bone(analytic_bones()[1]).front());
  const TriangleMesh mesh = muscle();
  const auto backend = build(GetParam(), bones, mesh);
  const std::vector<RigidMotion> poses(2);
  const auto all = ask(*backend, poses, mesh.vertices, all_nodes(mesh));
  std::vector<int> some;
  for (const int node : all_nodes(mesh)) {
    if (node % 3 == 0) {
      some.push_back(node);
    }
  }
  const auto subset = ask(*backend, poses, mesh.vertices, some);
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
  EXPECT_TRUE(ask(*backend, {RigidMotion{}}, mesh.vertices, {}).empty());
  if (backend->capabilities().point_queries) {
    mesh.vertices[5] = Vec3::Constant(std::nan(""));
    mesh.vertices[6] = Vec3::Constant(INFINITY);
    EXPECT_TRUE(ask(*backend, {RigidMotion{}}, mesh.vertices, {5, 6}).empty());
  }
}

bool has_parameter(const BackendEntry& entry, const std::string& name) {
  return std::any_of(entry.parameters.begin(), entry.parameters.end(),
                     [&](const ParameterSpec& spec) { return spec.name == name; });
}

/// Bones on which the side is not told by the closest triangle alone: a ball with a hole, over which the side changes
/// in empty space, and two balls of one bone that overlap.
TriangleMesh ball_with_a_hole() {
  TriangleMesh mesh = make_sphere(sphere_radius_m, 4);
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    const auto corner = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(t[i])]; };
    return (corner(0) + corner(1) + corner(2)).normalized().x() > 0.985;
  });
  return mesh;
}

TriangleMesh overlapping_balls() {
  TriangleMesh mesh = make_sphere(0.8 * sphere_radius_m, 3);
  const TriangleMesh other = make_sphere(0.7 * sphere_radius_m, 3);
  const auto first = static_cast<int>(mesh.vertices.size());
  for (const Vec3& vertex : other.vertices) {
    mesh.vertices.emplace_back(vertex + Vec3(0, 0.9 * sphere_radius_m, 0));
  }
  for (const Triangle& t : other.triangles) {
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return mesh;
}

/// A muscle that slides, turns and shakes past two bones, with a jump in the middle; between the steps a response asks
/// about some nodes elsewhere.
void expect_that_budgets_change_no_bit(const BackendEntry& entry, const std::vector<Bone>& bones, const Vec3& start,
                                       const Vec3& slide, const Vec3& bones_at = Vec3::Zero()) {
  std::map<std::string, ParameterValue> common;
  if (has_parameter(entry, "query")) {
    common["query"] = std::string("node_distance");  // the budgets are for nodes
  }
  if (has_parameter(entry, "cells")) {
    common["cells"] = std::int64_t{24};
  }
  const TriangleMesh mesh = muscle();
  const auto build_with = [&](const std::string& word, int threads) {
    std::map<std::string, ParameterValue> given = common;
    given["motion_budgets"] = word;
    auto backend = entry.make(Parameters(entry.parameters, given, "test"));
    backend->build(bones, mesh, threads);
    return backend;
  };
  const auto plain = build_with("off", 1);
  std::vector<std::unique_ptr<CollisionBackend>> with;
  with.push_back(build_with("on", 1));
  with.push_back(build_with("on", 3));
  std::mt19937 random(11);
  std::normal_distribution<double> shake(0, 1e-4);
  std::size_t met = 0;
  for (int step = 0; step < 20; ++step) {
    const double turn = 0.01 * step + (step > 16 ? 0.8 : 0);
    const RigidMotion to_origin{Mat3::Identity(), -bones_at};
    const std::vector<RigidMotion> poses = {
        RigidMotion::about_axis(Vec3(1, 2, -0.5).normalized(), Vec3(0.01, 0, 0), turn) * to_origin,
        RigidMotion::about_axis(Vec3::UnitZ(), Vec3(0, 0.02, 0), -turn) * to_origin};
    std::vector<Vec3> positions = moved(mesh.vertices, {Mat3::Identity(), start + step * slide});
    for (Vec3& position : positions) {
      position += Vec3(shake(random), shake(random), shake(random));
    }
    std::vector<int> some;
    for (const int node : all_nodes(mesh)) {
      if (node % 7 == step % 7) {
        some.push_back(node);
      }
    }
    const std::vector<Vec3> elsewhere = moved(positions, {Mat3::Identity(), Vec3(-0.002, 0.001, 0)});
    const std::vector<Contact> expected = Contract::ask(*plain, poses, positions, all_nodes(mesh));
    std::vector<Contact> expected_of_some;
    plain->detect(elsewhere, some, expected_of_some);
    std::vector<Vec3> pushed = positions;
    std::vector<int> in_contact;
    for (const Contact& contact : expected) {
      pushed[static_cast<std::size_t>(contact.node)] += contact.depth_m * contact.normal;
      in_contact.push_back(contact.node);
    }
    std::sort(in_contact.begin(), in_contact.end());
    in_contact.erase(std::unique(in_contact.begin(), in_contact.end()), in_contact.end());
    std::vector<Contact> expected_of_pushed;
    plain->detect(pushed, in_contact, expected_of_pushed);
    met += expected.size();
    for (const auto& backend : with) {
      expect_same_bits(Contract::ask(*backend, poses, positions, all_nodes(mesh)), expected);
      std::vector<Contact> of_some;
      backend->detect(elsewhere, some, of_some);
      expect_same_bits(of_some, expected_of_some);
      // Where a response puts them, and from there the next step begins.
      std::vector<Contact> of_pushed;
      backend->detect(pushed, in_contact, of_pushed);
      expect_same_bits(of_pushed, expected_of_pushed);
    }
  }
  EXPECT_GT(met, 500U);
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
    const std::vector<Contact> contacts = ask(*backend, {tilted}, positions, all_nodes(mesh));
    ASSERT_GT(contacts.size(), 20U);
    std::vector<int> nodes;
    for (const Contact& contact : contacts) {
      positions[static_cast<std::size_t>(contact.node)] += contact.depth_m * contact.normal;
      nodes.push_back(contact.node);
    }
    EXPECT_TRUE(ask(*backend, {tilted}, positions, nodes).empty()) << shape.name;
  }
}

TEST_P(Contract, MotionBudgetsChangeNoBitOfAMotion) {
  const BackendEntry& entry = find_backend(GetParam());
  if (!has_parameter(entry, "motion_budgets")) {
    GTEST_SKIP() << GetParam() << " keeps no motion budgets";
  }
  const auto bone = [](const TriangleMesh& mesh) { return Bone{"bone", repair_mesh(mesh, "bone")}; };
  const std::vector<AnalyticBone> shapes = analytic_bones();
  expect_that_budgets_change_no_bit(entry, {bone(shapes[0].mesh), bone(shapes[1].mesh)}, Vec3::Zero(),
                                    {-3e-4, 0, 6e-4});
  expect_that_budgets_change_no_bit(entry, {bone(ball_with_a_hole()), bone(overlapping_balls())},
                                    {0.027, -0.006, 0.004}, {-1.1e-3, 0, 0});
  // As scans have it: far from the rest frame's origin, where a place has fewer digits than a touching distance.
  std::vector<Bone> far = {bone(shapes[0].mesh), bone(shapes[1].mesh)};
  const Vec3 away(1e4, -2e4, 3e4);
  for (Bone& bone_there : far) {
    for (Vec3& vertex : bone_there.surface.mesh.vertices) {
      vertex += away;
    }
  }
  expect_that_budgets_change_no_bit(entry, far, Vec3::Zero(), {-3e-4, 0, 6e-4}, away);
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

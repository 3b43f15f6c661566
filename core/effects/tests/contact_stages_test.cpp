// Effects that are stages of the collision step, and damping.
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/contact/tests/shape_backend.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/mesh/shapes.hpp"
#include "core/pbd/simulation.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {
namespace {

using Given = std::map<std::string, ParameterValue>;

std::unique_ptr<ContactStage> make_stage(const std::string& name, std::span<const Bone> bones, std::size_t nodes,
                                         const Given& given = {}) {
  const EffectEntry* entry = find_effect(name);
  return entry->make_stage({bones, nodes}, Parameters(entry->parameters, given, "test"));
}

std::unique_ptr<Effect> make_force(const std::string& name, const NodeOrder& order, const Given& given) {
  const EffectEntry* entry = find_effect(name);
  static const TriangleMesh no_mesh;
  static const std::vector<Body> no_bodies;
  return entry->make({no_mesh, no_bodies, order, {}, {}, {}}, Parameters(entry->parameters, given, "test"));
}

Particles at_rest(const std::vector<Vec3>& positions) {
  return {positions, std::vector<Vec3>(positions.size(), Vec3::Zero()), std::vector<double>(positions.size(), 1)};
}

NodeOrder order_of(const std::vector<Vec3>& positions) {
  return {positions, std::vector<Body>{{"nodes", 0, static_cast<int>(positions.size())}}};
}

PoseFunction resting(std::size_t bones) {
  return [bones](double, std::vector<RigidMotion>& poses) { poses.assign(bones, {}); };
}

Bone bone_of(const TriangleMesh& mesh) { return {"bone", {mesh, false, {}}}; }

constexpr double gravity_m_per_s2 = 9.80665;

TEST(Damping, VelocitiesDecayTheSameForAnyTimeStep) {
  for (const int substeps : {1, 7, 50}) {
    const std::vector<Vec3> positions(1, Vec3::Zero());
    ShapeBackend backend({});
    LoopParameters loop;
    loop.substeps = substeps;
    loop.time_step_s = 0.3 / substeps;
    Particles particles = at_rest(positions);
    particles.velocities[0] = Vec3(2, 0, -1);
    std::vector<std::unique_ptr<Effect>> effects;
    effects.push_back(make_force("damping", order_of(positions), {{"rate_per_s", 4.0}}));
    Simulation simulation(loop, particles, order_of(positions), std::move(effects), backend, ResponseKind::project,
                          resting(0));
    simulation.step_frame(1);
    EXPECT_LT((simulation.velocities()[0] - std::exp(-4 * 0.3) * Vec3(2, 0, -1)).norm(), 1e-12);
  }
}

/// How far a block has slid down a slope, and how far it has left the slope, after a second.
struct Slid {
  double down_m;
  double off_m;
};

Slid slide_down(double slope_rad, double coefficient) {
  const std::vector<Vec3> positions(1, Vec3::Zero());
  const Vec3 up(std::sin(slope_rad), 0, std::cos(slope_rad));
  const Vec3 down(std::cos(slope_rad), 0, -std::sin(slope_rad));
  ShapeBackend backend({half_space(up)});
  LoopParameters loop;
  loop.substeps = 1000;
  std::vector<std::unique_ptr<Effect>> effects;
  effects.push_back(make_force("gravity", order_of(positions), {}));
  Simulation simulation(loop, at_rest(positions), order_of(positions), std::move(effects), backend,
                        ResponseKind::project, resting(1));
  simulation.add_stage(make_stage("friction", std::vector<Bone>(1), 1, {{"coefficient", coefficient}}));
  simulation.step_frame(1);
  return {simulation.positions()[0].dot(down), simulation.positions()[0].dot(up)};
}

TEST(Friction, ABlockOnASlopeStaysUpToTheAngleOfFriction) {
  for (const double coefficient : {0.1, 0.5, 2.0}) {
    const Slid slid = slide_down(std::atan(coefficient) - 1e-6, coefficient);
    EXPECT_NEAR(slid.down_m, 0, 1e-12) << coefficient;
    EXPECT_NEAR(slid.off_m, 0, 1e-12) << coefficient;
  }
}

TEST(Friction, BeyondThatAngleItSlidesAsCoulombSays) {
  for (const double coefficient : {0.0, 0.1, 0.5}) {
    const double slope_rad = std::atan(coefficient) + 0.1;
    const double expected_m = 0.5 * gravity_m_per_s2 * (std::sin(slope_rad) - coefficient * std::cos(slope_rad));
    const Slid slid = slide_down(slope_rad, coefficient);
    EXPECT_NEAR(slid.down_m, expected_m, 0.002 * expected_m) << coefficient;  // a time step of 1 ms in a second
    EXPECT_NEAR(slid.off_m, 0, 1e-12);
  }
}

TEST(Friction, ABoneThatMovesTakesAlongWhatLiesOnIt) {
  const std::vector<Vec3> positions(1, Vec3::Zero());
  for (const double coefficient : {0.0, 0.2}) {
    ShapeBackend backend({half_space(Vec3::UnitZ())});
    LoopParameters loop;
    loop.substeps = 100;
    loop.interpolate_poses = true;
    std::vector<std::unique_ptr<Effect>> effects;
    effects.push_back(make_force("gravity", order_of(positions), {}));
    // Half of what friction can bear: 0.2 g.
    const auto along_m = [](double frame) { return 0.5 * 0.1 * gravity_m_per_s2 * 0.01 * frame * frame; };
    Simulation simulation(loop, at_rest(positions), order_of(positions), std::move(effects), backend,
                          ResponseKind::project, [&](double frame, std::vector<RigidMotion>& poses) {
                            poses.assign(1, {Mat3::Identity(), Vec3(along_m(frame), 0, 0)});
                          });
    simulation.add_stage(make_stage("friction", std::vector<Bone>(1), 1, {{"coefficient", coefficient}}));
    simulation.step_frame(1);
    EXPECT_NEAR(simulation.positions()[0].x(), coefficient > 0 ? along_m(1) : 0, 1e-12);
  }
}

TEST(Friction, TheOrderOfBonesDoesNotMatter) {
  const Vec3 left = Vec3(1, 0, 1).normalized();
  const Vec3 right = Vec3(-1, 0.3, 2).normalized();
  const std::vector<Vec3> positions(1, Vec3::Zero());
  std::vector<Vec3> ends;
  for (const auto& [first, second] : {std::pair(left, right), std::pair(right, left)}) {
    ShapeBackend backend({half_space(first), half_space(second)});
    LoopParameters loop;
    loop.substeps = 20;
    Particles particles = at_rest(positions);
    particles.velocities[0] = Vec3(0.1, 2, -3);
    Simulation simulation(loop, particles, order_of(positions), {}, backend, ResponseKind::project, resting(2));
    simulation.add_stage(make_stage("friction", std::vector<Bone>(2), 1, {{"coefficient", 0.3}}));
    simulation.step_frame(1);
    ends.push_back(simulation.positions()[0]);
    EXPECT_LT(ends.back().norm(), 0.039);  // 2 m/s for 20 ms, less friction
  }
  EXPECT_LT((ends[0] - ends[1]).norm(), 1e-15);
}

/// Runs one guard step by step.
struct Guarded {
  explicit Guarded(const TriangleMesh& mesh, const Given& given = {}) : bones(1), poses(1) {
    bones[0] = bone_of(mesh);
    guard = make_stage("tunnelling_guard", bones, 1, given);
  }

  /// Whether the guard moved the node, which is then at `at`.
  bool step(const Vec3& to, const RigidMotion& pose = {}) {
    std::vector<Vec3> start(1, at);
    std::vector<Vec3> predicted(1, to);
    const std::vector<int> nodes(1, 0);
    const std::vector<RigidMotion> next(1, pose);
    const bool held = !guard->after_bones({start, predicted, nodes, poses, next, {}}).empty();
    EXPECT_EQ(guard->contact_count(), held ? 1 : 0);
    EXPECT_EQ(held, predicted[0] != to);
    at = predicted[0];
    poses = next;
    return held;
  }

  std::vector<Bone> bones;
  std::vector<RigidMotion> poses;
  std::unique_ptr<ContactStage> guard;
  Vec3 at = Vec3::Zero();
};

/// Through a bone that no node was expected to touch, from far on one side to far on the other.
TEST(TunnellingGuard, HoldsANodeThatPassesABoneItWasNotExpectedAt) {
  for (const char* rule : {"crossing", "angle"}) {
    const EffectEntry* entry = find_effect("tunnelling_guard");
    const std::vector<Bone> bones(1, bone_of(make_box({0.1, 0.1, 0.1}, 4)));
    const std::vector<char> untouched(1, 1);
    StageInput input{bones, 1};
    input.untouched = untouched;
    const auto guard = entry->make_stage(input, Parameters(entry->parameters, {{"rule", rule}}, "test"));
    std::vector<Vec3> start(1, Vec3(0.01, 0.02, 0.5));
    std::vector<Vec3> predicted(1, Vec3(0.01, 0.02, -0.5));
    const std::vector<int> nodes(1, 0);
    const std::vector<RigidMotion> poses(1);
    EXPECT_EQ(guard->after_bones({start, predicted, nodes, poses, poses, {}}).size(), 1U) << rule;
    EXPECT_NEAR(predicted[0].z(), 0.1, 1e-12) << rule;
    predicted[0] = Vec3(0.01, 0.02, 0.4);
    EXPECT_TRUE(guard->after_bones({start, predicted, nodes, poses, poses, {}}).empty()) << rule;
  }
}

TEST(TunnellingGuard, PutsNodesBackToTheMargin) {
  for (const char* rule : {"crossing", "angle"}) {
    const EffectEntry* entry = find_effect("tunnelling_guard");
    const std::vector<Bone> bones(1, bone_of(make_box({0.1, 0.1, 0.1}, 4)));
    StageInput input{bones, 1};
    input.contacts.margin_m = 0.002;
    const auto guard = entry->make_stage(input, Parameters(entry->parameters, {{"rule", rule}}, "test"));
    std::vector<Vec3> start(1, Vec3(0.01, 0.02, 0.5));
    std::vector<Vec3> predicted(1, Vec3(0.01, 0.02, -0.5));
    const std::vector<int> nodes(1, 0);
    const std::vector<RigidMotion> poses(1);
    EXPECT_EQ(guard->after_bones({start, predicted, nodes, poses, poses, {}}).size(), 1U) << rule;
    EXPECT_LT((predicted[0] - Vec3(0.01, 0.02, 0.102)).norm(), 1e-12) << rule;
  }
}

TEST(Margin, ANodeComesToRestAtItsDistance) {
  const std::vector<Bone> bones(1, bone_of(make_box({0.1, 0.1, 0.1}, 4)));
  for (const double thickness_m : {0.0, 1e-4, 3e-3}) {
    const std::vector<Vec3> positions(1, Vec3(0.02, 0.03, 0.12));
    ShapeBackend backend({half_space(Vec3::UnitZ(), 0.1)});
    LoopParameters loop;
    loop.substeps = 500;
    std::vector<std::unique_ptr<Effect>> effects;
    effects.push_back(make_force("gravity", order_of(positions), {}));
    Simulation simulation(loop, at_rest(positions), order_of(positions), std::move(effects), backend,
                          ResponseKind::project, resting(1));
    simulation.add_stage(make_stage("margin", bones, 1, {{"thickness_m", thickness_m}}));
    simulation.step_frame(1);
    EXPECT_LT((simulation.positions()[0] - Vec3(0.02, 0.03, 0.1 + thickness_m)).norm(), 1e-15) << thickness_m;
  }
}

/// At positions near a sphere's facets, by the closest point of brute force.
TEST(Margin, ContactsAreThoseOfTheExactDistance) {
  const std::vector<Bone> bones(2, bone_of(make_sphere(0.02, 2)));
  const SignedSurface exact(bones[0].surface);
  const RigidMotion pose{RigidMotion::about_axis(Vec3::UnitX(), Vec3(0.01, 0, 0), 0.7)};
  const std::vector<RigidMotion> poses = {pose, {Mat3::Identity(), Vec3(0.03, 0, 0)}};
  constexpr double thickness_m = 0.002;
  std::vector<Vec3> positions;
  std::vector<int> nodes;
  for (int i = 0; i < 3000; ++i) {
    nodes.push_back(i);
    const double angle_rad = 2.4 * i;  // a spiral about the middle
    positions.push_back(1e-5 * i * Vec3(std::cos(angle_rad), std::sin(angle_rad), std::sin(0.01 * i)));
  }
  const auto margin = make_stage("margin", bones, positions.size(), {{"thickness_m", thickness_m}});
  for (int step = 0; step < 3; ++step) {  // afterwards most are known to be free
    std::vector<Contact> contacts = {{.node = 7, .bone = 0, .depth_m = 1, .normal = Vec3::UnitY()}};
    margin->add_contacts({positions, positions, nodes, poses, poses, {}}, contacts);
    std::size_t next = 0;
    for (int bone = 0; bone < 2; ++bone) {
      for (const int node : nodes) {
        const Vec3 point = poses[bone].apply_inverse(positions[node]);
        const SignedPoint located = exact.locate(point);
        const double depth_m = thickness_m - located.signed_distance_m();
        const bool is_known = bone == 0 && node == 7;
        // Deeper than the skin is thick it is the backend's to find.
        if (!is_known && (depth_m <= 0 || depth_m > 2 * thickness_m)) continue;
        while (next < contacts.size() && contacts[next].bone == bone && contacts[next].node < node) ++next;
        ASSERT_LT(next, contacts.size());
        const Contact& found = contacts[next++];
        ASSERT_EQ(found.node, node);
        ASSERT_EQ(found.bone, bone);
        EXPECT_NEAR(found.depth_m, is_known ? 1 + thickness_m : depth_m, 1e-15);
        if (!is_known) {
          EXPECT_LT((found.normal - poses[bone].apply_to_direction(exact.outward(point, located))).norm(), 1e-12);
        }
      }
    }
    for (std::size_t i = 1; i < contacts.size(); ++i) {
      EXPECT_LT(std::pair(contacts[i - 1].bone, contacts[i - 1].node), std::pair(contacts[i].bone, contacts[i].node));
    }
    EXPECT_EQ(margin->contact_count(), static_cast<int>(contacts.size()) - 1);
    for (const Contact& contact : contacts) EXPECT_GT(contact.depth_m, 0);
  }
}

/// Where a response leaves a node.
Vec3 responded(const std::vector<Shape>& shapes, const Vec3& at, bool out_of_all) {
  ShapeBackend backend(shapes);
  Response response(ResponseKind::project);
  const EffectEntry& entry = *find_effect("multi_bone");
  if (out_of_all) entry.set_response(response, Parameters(entry.parameters, {}, "test"));
  const std::vector<RigidMotion> poses(shapes.size());
  std::vector<Vec3> predicted(1, at);
  const std::vector<int> nodes(1, 0);
  std::vector<Contact> contacts;
  backend.update(poses, predicted);
  backend.detect(predicted, nodes, contacts);
  response.resolve(backend, {predicted, poses, poses}, contacts, predicted);
  return predicted[0];
}

/// Two sides of a groove, 30 degrees apart, and the bottom where they meet: the node is in one of them only, and is
/// pushed into the other.
TEST(MultiBone, ANodeInAWedgeEndsOutsideBothSides) {
  const Vec3 left = Vec3(std::cos(0.26), 0, std::sin(0.26));
  const Vec3 right = Vec3(-std::cos(0.26), 0, std::sin(0.26));
  const std::vector<Shape> groove = {half_space(left), half_space(right)};
  const std::vector<Shape> swapped = {half_space(right), half_space(left)};
  for (const Vec3& at : {Vec3(0, 0, -0.001), Vec3(-0.002, 0.5, -0.004), Vec3(0.0001, 0, -0.0005)}) {
    const Vec3 found = responded(groove, at, true);
    EXPECT_GT(found.dot(left), -1e-10);
    EXPECT_GT(found.dot(right), -1e-10);
    EXPECT_LT((found - Vec3(0, at.y(), 0)).norm(), 1e-9) << at.transpose();
    EXPECT_EQ(found, responded(swapped, at, true));
  }
  const Vec3 summed = responded(groove, {-0.002, 0.5, -0.004}, false);
  EXPECT_LT(std::min(summed.dot(left), summed.dot(right)), -1e-5);
}

TEST(MultiBone, BonesThatOverlapPushANodeOnce) {
  const std::vector<Shape> twice(2, half_space(Vec3::UnitZ()));
  EXPECT_LT((responded(twice, {0, 0, -0.001}, true)).norm(), 1e-11);
  EXPECT_NEAR(responded(twice, {0, 0, -0.001}, false).z(), 0.001, 1e-15);
}

/// Between two balls, whose tangent planes leave less room than they do.
TEST(MultiBone, ANodeBetweenCurvedBonesEndsOutsideThem) {
  const std::vector<Shape> balls = {ball({-0.01, 0, 0}, 0.0105), ball({0.01, 0, 0}, 0.0105)};
  const Vec3 found = responded(balls, {0.0001, 0.001, 0}, true);
  for (const Shape& each : balls) EXPECT_GT(each.signed_distance_m(found), -1e-9);
  EXPECT_LT(found.norm(), 2 * std::sqrt(0.0105 * 0.0105 - 0.01 * 0.01));
}

/// Two bones close on a node, from a gap of 2 mm to one of -1 mm, and it does not jump.
TEST(MultiBone, APinchedNodeKeepsToTheMiddle) {
  Vec3 at(0.0004, 0, 0);
  for (double gap_m = 2e-3; gap_m > -1e-3; gap_m -= 1e-5) {
    const std::vector<Shape> jaws = {half_space(Vec3::UnitX(), -gap_m / 2), half_space(-Vec3::UnitX(), -gap_m / 2)};
    const Vec3 next = responded(jaws, at, true);
    EXPECT_LT((next - at).norm(), 6e-6) << gap_m;
    at = next;
  }
  EXPECT_NEAR(at.x(), 0, 1e-6);
}

constexpr double half_thickness_m = 0.002;
TriangleMesh plate() { return make_box({0.1, 0.1, half_thickness_m}, 5); }

TEST(ContactStages, ShareTheSurfaceOfABoneAndKeepIt) {
  const std::vector<Bone> bones(1, bone_of(make_sphere(0.02, 2)));
  const std::weak_ptr<const SignedSurface> shared = bones[0].kept_signed_distance();
  const long used = shared.use_count();
  auto margin = make_stage("margin", bones, 1);
  EXPECT_EQ(shared.use_count(), used + 1);
  auto guard = make_stage("tunnelling_guard", bones, 1);
  EXPECT_EQ(shared.use_count(), used + 2);
  bones[0].shared.release();
  EXPECT_FALSE(shared.expired());
  margin.reset();
  guard.reset();
  EXPECT_TRUE(shared.expired());
}

TEST(TunnellingGuard, ABulletStopsWhereItHitsThePlate) {
  for (const char* rule : {"crossing", "angle"}) {
    for (const double far_m : {-0.0021, -0.01, -10.0}) {  // 1000 m/s and a time step of 10 ms
      Guarded node(plate(), {{"rule", std::string(rule)}});
      node.at = Vec3(0.01, 0.02, 0.05);
      EXPECT_FALSE(node.step({0.01, 0.02, 0.04}));
      EXPECT_TRUE(node.step({0.01, 0.02, far_m})) << rule << " " << far_m;
      EXPECT_LT((node.at - Vec3(0.01, 0.02, half_thickness_m)).norm(), 1e-15);
    }
  }
}

/// The plate turns by 30 degrees a frame through nodes at rest.
TEST(TunnellingGuard, APlateThatTurnsSweepsNodesAlong) {
  Guarded node(plate());
  node.at = Vec3(0.06, 0.01, 0.01);
  for (int frame = 1; frame <= 24; ++frame) {
    const RigidMotion pose = RigidMotion::about_axis(Vec3::UnitY(), Vec3::Zero(), -frame * std::numbers::pi / 6);
    node.step(node.at, pose);
    const Vec3 local = pose.apply_inverse(node.at);
    EXPECT_GE(local.z(), half_thickness_m - 1e-15) << "frame " << frame;
    EXPECT_LT(std::abs(local.x()), 0.1);
  }
}

/// Slower than the plate is thick: through it in many steps, and out by a response that knows only the nearest side.
TEST(TunnellingGuard, ANodeThatCreepsThroughIsPutBackToItsSide) {
  Guarded node(plate());
  node.at = Vec3(0.01, 0.02, 0.003);
  for (int step = 0; step < 20; ++step) {
    const bool past_the_middle = node.at.z() - 0.0006 < 0;
    EXPECT_EQ(node.step(node.at - Vec3(0, 0, 0.0006)), past_the_middle) << step;
    EXPECT_GT(node.at.z(), -1e-12);
  }
  Guarded pushed(plate());
  pushed.at = Vec3(0.01, 0.02, 0.003);
  EXPECT_FALSE(pushed.step({0.01, 0.02, 0.001}));
  EXPECT_TRUE(pushed.step({0.01, 0.02, -half_thickness_m}));
  EXPECT_LT((pushed.at - Vec3(0.01, 0.02, half_thickness_m)).norm(), 1e-15);
}

TEST(TunnellingGuard, ACutCornerDoesNotStopTheNode) {
  Guarded node(make_box({0.1, 0.1, 0.1}, 3));
  node.at = Vec3(0.11, 0.01, 0.05);
  EXPECT_FALSE(node.step({0.05, 0.01, 0.11}));
  EXPECT_FALSE(node.step({0.05, 0.01, 0.1}));
  EXPECT_FALSE(node.step({-0.05, 0.01, 0.2}));
}

/// What counts is each way through, not the first entry and the last exit.
TEST(TunnellingGuard, ABulletThatCutsACornerStopsAtThePlateBehind) {
  TriangleMesh mesh = make_box({0.1, 0.1, 0.1}, 3);
  const int first = static_cast<int>(mesh.vertices.size());
  for (const Vec3& vertex : plate().vertices)
    mesh.vertices.push_back(Vec3(vertex.z(), vertex.y(), vertex.x()) + Vec3(-0.2, 0, 0.38));
  for (const auto& [a, b, c] : plate().triangles) mesh.triangles.push_back({first + a, first + c, first + b});
  Guarded node(mesh);
  node.at = Vec3(0.15, 0.01, 0.03);
  EXPECT_TRUE(node.step({-0.3, 0.01, 0.48}));
  EXPECT_NEAR(node.at.x(), -0.2 + half_thickness_m, 1e-15);
}

/// Inside by less than a field's error, all the way around.
TEST(TunnellingGuard, ANodeThatSlidesAroundABoneIsLeftAlone) {
  Guarded node(make_sphere(0.02, 4));
  node.at = Vec3(0.021, 0, 0);
  for (int degrees = 0; degrees <= 720; degrees += 2) {
    const double angle_rad = degrees * std::numbers::pi / 180;
    EXPECT_FALSE(node.step(0.0198 * Vec3(std::cos(angle_rad), std::sin(angle_rad), 0))) << degrees;
  }
  EXPECT_FALSE(node.step({0.03, 0, 0}));
  EXPECT_TRUE(node.step({-0.03, 0, 0}));
}

/// As when the surfaces overlap at rest: a node that begins inside leaves by the side that is nearest.
TEST(TunnellingGuard, WhoBeginsInsideMayLeave) {
  Guarded node(plate());
  node.at = Vec3(0, 0, -0.001);
  EXPECT_FALSE(node.step({0, 0, -0.0015}));
  EXPECT_FALSE(node.step({0, 0, -0.003}));
  EXPECT_TRUE(node.step({0, 0, 0.003}));
  EXPECT_LT((node.at - Vec3(0, 0, -half_thickness_m)).norm(), 1e-15);
}

/// A path that cuts the edge of a box: the directions to the surface at its ends differ by 90 degrees.
TEST(TunnellingGuard, RuleAngleHoldsBeyondItsAngle) {
  for (const double angle_deg : {80.0, 100.0}) {
    Guarded node(make_box({0.1, 0.1, 0.1}, 3), {{"rule", std::string("angle")}, {"angle_deg", angle_deg}});
    node.at = Vec3(0.11, 0.01, 0.05);
    EXPECT_EQ(node.step({0.05, 0.01, 0.11}), angle_deg < 90) << angle_deg;
  }
}

/// Out of one plate and into the next in one step, where the nearest side is again the upper one.
TEST(TunnellingGuard, ANodeInAPlateDoesNotReachThePlateBelow) {
  TriangleMesh mesh = plate();
  const int first = static_cast<int>(mesh.vertices.size());
  for (const Vec3& vertex : plate().vertices) mesh.vertices.push_back(vertex - Vec3(0, 0, 0.05));
  for (const auto& [a, b, c] : plate().triangles) mesh.triangles.push_back({first + a, first + b, first + c});
  Guarded node(mesh);
  node.at = Vec3(0.01, 0.02, 0.003);
  EXPECT_FALSE(node.step({0.01, 0.02, 0.001}));
  EXPECT_TRUE(node.step({0.01, 0.02, -0.05 + half_thickness_m - 0.0005}));
  EXPECT_LT((node.at - Vec3(0.01, 0.02, half_thickness_m)).norm(), 1e-15);
}

TEST(TunnellingGuard, ANodeThatBeginsOnTheSurfaceIsOfThatSide) {
  Guarded node(plate());
  node.at = Vec3(0.01, 0.02, half_thickness_m);
  EXPECT_TRUE(node.step({0.01, 0.02, -0.001}));
  EXPECT_LT((node.at - Vec3(0.01, 0.02, half_thickness_m)).norm(), 1e-15);
}

/// Onto one side and pushed onto the other by a response: the path touches the surface at both ends, and rounding
/// decides whether it crosses it at either.
TEST(TunnellingGuard, FromOneSideOntoTheOtherIsThrough) {
  const auto pose = [](int step) { return RigidMotion::about_axis(-Vec3::UnitY(), Vec3(-1, 0, 0), 0.01 * step); };
  for (int i = 0; i < 1000; ++i) {
    const Vec3 beside(1e-4 * (i % 97), 1e-4 * (i % 89), 0);
    const Vec3 above = beside + Vec3(0, 0, half_thickness_m);
    const Vec3 below = beside + Vec3(1e-4, 0, -half_thickness_m);
    Guarded node(plate());
    node.poses[0] = pose(0);
    node.at = pose(0).apply(above + Vec3(0, 0, 0.01));
    ASSERT_FALSE(node.step(pose(1).apply(above), pose(1)));
    EXPECT_TRUE(node.step(pose(2).apply(below), pose(2))) << i;
    EXPECT_TRUE(node.step(pose(3).apply(below), pose(3))) << i;
    EXPECT_GT(pose(3).apply_inverse(node.at).z(), 0) << i;
  }
}

TEST(TunnellingGuard, WhatIsNotFiniteIsLeftToTheLoop) {
  Guarded node(plate());
  node.at = Vec3(0, 0, 0.01);
  std::vector<Vec3> start(1, node.at);
  std::vector<Vec3> predicted(1, Vec3(0, 0, std::nan("")));
  const std::vector<int> nodes(1, 0);
  EXPECT_TRUE(node.guard->after_bones({start, predicted, nodes, node.poses, node.poses, {}}).empty());
}

TEST(Stages, NamesAreThoseOfTheEffects) {
  const std::vector<Bone> bones(1, bone_of(plate()));
  for (const EffectEntry& entry : effect_registry()) {
    ASSERT_EQ((entry.make != nullptr) + (entry.make_stage != nullptr) + (entry.set_response != nullptr), 1)
        << entry.name;
    if (entry.make_stage) {
      const TriangleMesh no_muscle;
      const StageInput input{.bones = bones, .mesh = &no_muscle};
      EXPECT_EQ(entry.make_stage(input, Parameters(entry.parameters, {}, "test"))->name(), entry.name);
    }
  }
}

}  // namespace
}  // namespace musclebench

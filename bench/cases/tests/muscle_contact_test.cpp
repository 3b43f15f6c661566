// Contacts between muscles: all backends that detect them against brute force, the loop against physics.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "core/contact/tests/shape_backend.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/mesh/shapes.hpp"
#include "core/pbd/muscle_contact_stage.hpp"
#include "core/pbd/simulation.hpp"
#include "core/referee/muscle_referee.hpp"

namespace musclebench {
namespace {

std::vector<const BackendEntry*> followers() {
  std::vector<const BackendEntry*> able;
  for (const BackendEntry& entry : backend_registry()) {
    if (entry.make_muscle_detector) able.push_back(&entry);
  }
  return able;
}

/// Muscles of one mesh.
struct Muscles {
  TriangleMesh mesh;
  std::vector<Body> bodies;

  void add(const std::string& name, const TriangleMesh& surface, const Vec3& at_m) {
    const auto first_node = static_cast<int>(mesh.vertices.size());
    const std::size_t first_triangle = mesh.triangles.size();
    for (const Vec3& vertex : surface.vertices) mesh.vertices.push_back(vertex + at_m);
    for (const auto& [a, b, c] : surface.triangles) {
      mesh.triangles.push_back({first_node + a, first_node + b, first_node + c});
    }
    bodies.push_back({name, first_node, static_cast<int>(mesh.vertices.size()), first_triangle, mesh.triangles.size()});
  }

  [[nodiscard]] std::unique_ptr<MuscleContactDetector> detector(
      const BackendEntry& entry, const std::vector<MusclePair>& pairs, int threads = 1,
      const std::map<std::string, ParameterValue>& parameters = {}) const {
    return entry.make_muscle_detector(Parameters(entry.parameters, parameters, entry.name), {mesh, bodies, pairs},
                                      threads);
  }
};

/// A ball, a finer one that overlaps it by 4 mm, and a capsule that touches both.
Muscles three_muscles() {
  Muscles muscles;
  muscles.add("ball", make_sphere(0.02, 3), Vec3(0, 0, 0));
  muscles.add("fine", make_sphere(0.015, 4), Vec3(0.031, 0, 0));
  muscles.add("bar", make_capsule(0.01, 0.03, 20), Vec3(0.014, 0.021, 0));
  return muscles;
}

const std::vector<MusclePair> all_pairs = {{0, 1}, {0, 2}, {1, 2}};

/// They slide along each other, turn and bulge.
std::vector<Vec3> moved(const Muscles& muscles, double time) {
  std::vector<Vec3> positions;
  for (std::size_t i = 0; i < muscles.mesh.vertices.size(); ++i) {
    const std::size_t muscle = body_of(muscles.bodies, static_cast<int>(i));
    const double angle = time * (muscle == 0 ? 0.4 : muscle == 1 ? -0.6 : 0.2);
    const Vec3& v = muscles.mesh.vertices[i];
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const Vec3 turned(c * v.x() - s * v.y(), s * v.x() + c * v.y(), v.z());
    positions.push_back(turned + 0.0005 * std::sin(900 * v.z() + 5 * time) * Vec3(1, 1, 0));
  }
  return positions;
}

void expect_same(const std::vector<MuscleContact>& found, const std::vector<MuscleContact>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].node, expected[i].node);
    EXPECT_EQ(found[i].muscle, expected[i].muscle);
    EXPECT_EQ(found[i].triangle, expected[i].triangle);
    EXPECT_EQ(found[i].weights, expected[i].weights);
    EXPECT_EQ(found[i].depth_m, expected[i].depth_m);
    EXPECT_EQ(found[i].normal, expected[i].normal);
  }
}

TEST(MuscleContact, ExactBackendsFindWhatBruteForceFindsToTheBitWhileMusclesMove) {
  const Muscles muscles = three_muscles();
  const auto truth = muscles.detector(find_backend("brute_force"), all_pairs);
  for (const BackendEntry* entry : followers()) {
    if (!entry->exact || entry->name == "brute_force") continue;
    std::vector<std::unique_ptr<MuscleContactDetector>> detectors;
    for (const int threads : {1, 2, 3}) detectors.push_back(muscles.detector(*entry, all_pairs, threads));
    detectors.push_back(muscles.detector(*entry, all_pairs, 1, {{"clearance_cache", std::string("off")}}));
    std::size_t most = 0;
    for (int step = 0; step < 40; ++step) {
      const std::vector<Vec3> positions = moved(muscles, step < 30 ? 0.02 * step : 0.9);  // and a leap
      std::vector<MuscleContact> expected;
      truth->detect(positions, expected);
      most = std::max(most, expected.size());
      for (const auto& detector : detectors) {
        std::vector<MuscleContact> found;
        detector->detect(positions, found);
        expect_same(found, expected);
        if (testing::Test::HasFailure()) FAIL() << entry->name << " in step " << step;
      }
    }
    EXPECT_GT(most, 50U) << "hardly anything to find";
  }
}

/// What is asked about two muscles of three pays for two.
TEST(MuscleContact, AMuscleThatTouchesNoneHasNoTree) {
  const Muscles muscles = three_muscles();
  const auto bytes = [&](const std::vector<MusclePair>& pairs) {
    return muscles.detector(find_backend("bvh"), pairs, 1, {{"clearance_cache", std::string("off")}})
        ->structure_bytes();
  };
  EXPECT_LT(bytes({{0, 2}}), bytes({{0, 1}, {0, 2}}) * 2 / 3);
  for (const BackendEntry* entry : followers()) {
    const auto all = muscles.detector(*entry, all_pairs);
    const auto some = muscles.detector(*entry, {{0, 2}});
    std::vector<MuscleContact> of_all;
    std::vector<MuscleContact> found;
    for (const double time : {0.0, 0.1}) {
      all->detect(moved(muscles, time), of_all);
      some->detect(moved(muscles, time), found);
      std::erase_if(of_all, [&](const MuscleContact& contact) {
        return contact.muscle == 1 || muscles.bodies[1].has_node(contact.node);
      });
      ASSERT_GT(found.size(), 5U) << entry->name;
      expect_same(found, of_all);
    }
  }
}

TEST(MuscleContact, EveryBackendFindsNoNodeThatIsFreeAndNoDepthBelowTheTruth) {
  const Muscles muscles = three_muscles();
  const auto truth = muscles.detector(find_backend("brute_force"), all_pairs);
  for (const BackendEntry* entry : followers()) {
    const auto detector = muscles.detector(*entry, all_pairs, 2);
    std::size_t found_in_all = 0;
    std::size_t expected_in_all = 0;
    for (int step = 0; step < 12; ++step) {
      const std::vector<Vec3> positions = moved(muscles, 0.05 * step);
      std::vector<MuscleContact> expected;
      std::vector<MuscleContact> found;
      truth->detect(positions, expected);
      detector->detect(positions, found);
      found_in_all += found.size();
      expected_in_all += expected.size();
      for (const MuscleContact& contact : found) {
        const auto same = std::ranges::find_if(
            expected, [&](const MuscleContact& e) { return e.node == contact.node && e.muscle == contact.muscle; });
        ASSERT_NE(same, expected.end()) << entry->name << ": node " << contact.node << " is free";
        EXPECT_GE(contact.depth_m, same->depth_m * (1 - 1e-12)) << entry->name;
        EXPECT_NEAR(contact.weights.sum(), 1, 1e-12);
        EXPECT_GE(contact.weights.minCoeff(), 0);
        EXPECT_NEAR(contact.normal.norm(), 1, 1e-12);
      }
    }
    EXPECT_GT(found_in_all, expected_in_all / 4) << entry->name << " finds next to nothing";
  }
}

TEST(MuscleContact, EveryBackendTellsTheTimeOfEachPair) {
  const Muscles muscles = three_muscles();
  for (const BackendEntry* entry : followers()) {
    const auto detector = muscles.detector(*entry, all_pairs, 2);
    std::vector<MuscleContact> found;
    for (const double time : {0.0, 0.9}) {
      detector->detect(moved(muscles, time), found);
      ASSERT_EQ(detector->pair_times().size(), all_pairs.size()) << entry->name;
      Nanoseconds sum_ns = 0;
      for (std::size_t pair = 0; pair < all_pairs.size(); ++pair) {
        EXPECT_EQ(detector->pair_times()[pair].muscles, all_pairs[pair]) << entry->name;
        EXPECT_GE(detector->pair_times()[pair].detect_ns, 0) << entry->name;
        sum_ns += detector->pair_times()[pair].detect_ns;
      }
      EXPECT_GT(sum_ns, 0) << entry->name;
    }
  }
}

TEST(MuscleContact, OnlyNamedPairsCollide) {
  const Muscles muscles = three_muscles();
  for (const BackendEntry* entry : followers()) {
    const auto detector = muscles.detector(*entry, {{0, 2}});
    std::vector<MuscleContact> found;
    detector->detect(muscles.mesh.vertices, found);
    ASSERT_FALSE(found.empty()) << entry->name;
    for (const MuscleContact& contact : found) {
      const auto own = static_cast<int>(body_of(muscles.bodies, contact.node));
      EXPECT_TRUE((own == 0 && contact.muscle == 2) || (own == 2 && contact.muscle == 0)) << entry->name;
    }
  }
}

TEST(MuscleContact, TheRefereeAgreesWithBruteForce) {
  const Muscles muscles = three_muscles();
  const auto brute_force = muscles.detector(find_backend("brute_force"), all_pairs);
  MuscleReferee referee(muscles.mesh, {muscles.bodies, {{1, 2}, {0, 2}, {0, 1}}});
  for (int step = 0; step < 12; ++step) {
    const std::vector<Vec3> positions = moved(muscles, 0.05 * step);
    std::vector<MuscleContact> expected;
    brute_force->detect(positions, expected);
    std::vector<Contact> truth;
    referee.judge(positions, truth);
    ASSERT_EQ(truth.size(), expected.size());
    for (std::size_t i = 0; i < truth.size(); ++i) {
      EXPECT_EQ(truth[i].node, expected[i].node);
      EXPECT_EQ(truth[i].bone, expected[i].muscle);
      EXPECT_NEAR(truth[i].depth_m, expected[i].depth_m, 1e-15);
      EXPECT_LT((truth[i].normal - expected[i].normal).norm(), 1e-9);
    }
  }
  EXPECT_GT(referee.last_work(), 0);
}

/// Two balls whose nodes fly towards each other, without any effect: what happens is contact alone.
struct TwoBalls {
  Muscles muscles;
  Particles particles;
  std::vector<Bone> no_bones;
  ShapeBackend nothing{{}};
  std::unique_ptr<Simulation> simulation;
  double mass_of_second;

  TwoBalls(const BackendEntry& entry, double mass_ratio, int threads, bool is_right_first = false)
      : mass_of_second(mass_ratio) {
    const TriangleMesh sphere = make_sphere(0.02, 2);
    TriangleMesh mirrored = sphere;
    for (Vec3& vertex : mirrored.vertices) vertex.x() = -vertex.x();
    for (Triangle& triangle : mirrored.triangles) std::swap(triangle[1], triangle[2]);
    if (is_right_first) muscles.add("right", mirrored, Vec3(0.021, 0, 0));
    muscles.add("left", sphere, Vec3(-0.021, 0, 0));
    if (!is_right_first) muscles.add("right", mirrored, Vec3(0.021, 0, 0));
    particles.positions = muscles.mesh.vertices;
    for (std::size_t i = 0; i < particles.positions.size(); ++i) {
      const bool is_left = muscles.bodies[body_of(muscles.bodies, static_cast<int>(i))].name == "left";
      particles.velocities.emplace_back(is_left ? 1 : -1, 0, 0);
      particles.inverse_masses.push_back(is_left ? 1 : 1 / mass_ratio);
    }
    LoopParameters loop;
    loop.time_step_s = 1e-4;
    loop.substeps = 10;
    simulation = std::make_unique<Simulation>(
        loop, particles, NodeOrder(particles.positions, muscles.bodies), std::vector<std::unique_ptr<Effect>>{},
        nothing, ResponseKind::project, [](double, std::vector<RigidMotion>& poses) { poses.clear(); }, threads);
    std::vector<std::unique_ptr<MuscleContactDetector>> detectors;
    detectors.push_back(muscles.detector(entry, {{0, 1}}, threads));
    simulation->add_stage(std::make_unique<MuscleContactStage>(std::move(detectors), muscles.mesh.triangles,
                                                               default_projection_steps,
                                                               ContactRowSolver(particles.inverse_masses)));
  }

  [[nodiscard]] Vec3 momentum() const {
    Vec3 sum = Vec3::Zero();
    const std::vector<Vec3> velocities = simulation->velocities();
    for (std::size_t i = 0; i < velocities.size(); ++i) sum += velocities[i] / particles.inverse_masses[i];
    return sum;
  }

  [[nodiscard]] double deepest_m() const {
    MuscleReferee referee(muscles.mesh, {muscles.bodies, {{1}, {0}}});
    std::vector<Contact> truth;
    referee.judge(simulation->positions(), truth);
    double deepest = 0;
    for (const Contact& contact : truth) deepest = std::max(deepest, contact.depth_m);
    return deepest;
  }
};

TEST(MuscleContact, TwoBallsKeepTheirMomentumAndStopEachOther) {
  for (const BackendEntry* entry : followers()) {
    for (const double mass_ratio : {1.0, 5.0}) {
      TwoBalls balls(*entry, mass_ratio, 1);
      const Vec3 before = balls.momentum();
      bool touched = false;
      double deepest_m = 0;
      for (int frame = 1; frame <= 8; ++frame) {
        balls.simulation->step_frame(frame);
        touched = touched || balls.simulation->stages()[0]->contact_count() > 0;
        deepest_m = std::max(deepest_m, balls.deepest_m());
      }
      EXPECT_TRUE(touched) << entry->name;
      const double scale = static_cast<double>(balls.particles.size()) * mass_ratio;
      EXPECT_LT((balls.momentum() - before).norm(), 1e-9 * scale) << entry->name << mass_ratio;
      // 8 mm of approach, of which the contact has to stop all but its own error.
      EXPECT_LT(deepest_m, 0.0005) << entry->name << mass_ratio;
    }
  }
}

TEST(MuscleContact, EqualBallsStayMirrorImages) {
  for (const BackendEntry* entry : followers()) {
    TwoBalls balls(*entry, 1, 1);
    for (int frame = 1; frame <= 8; ++frame) balls.simulation->step_frame(frame);
    const std::vector<Vec3>& positions = balls.simulation->positions();
    const auto half = static_cast<std::size_t>(balls.muscles.bodies[1].first_node);
    for (std::size_t i = 0; i < half; ++i) {
      const Vec3 mirrored(-positions[half + i].x(), positions[half + i].y(), positions[half + i].z());
      ASSERT_LT((positions[i] - mirrored).norm(), 1e-6) << entry->name << ": node " << i;
    }
  }
}

TEST(MuscleContact, TheOrderOfTheMusclesChangesNothingButRounding) {
  for (const BackendEntry* entry : followers()) {
    TwoBalls balls(*entry, 2, 1);
    TwoBalls other_way_round(*entry, 2, 1, true);
    for (int frame = 1; frame <= 8; ++frame) {
      balls.simulation->step_frame(frame);
      other_way_round.simulation->step_frame(frame);
    }
    const std::vector<Vec3>& positions = balls.simulation->positions();
    const std::vector<Vec3>& others = other_way_round.simulation->positions();
    const std::size_t half = positions.size() / 2;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      ASSERT_LT((positions[i] - others[(i + half) % positions.size()]).norm(), 1e-12) << entry->name << ": node " << i;
    }
  }
}

TEST(MuscleContact, ThreadsChangeNoBit) {
  for (const BackendEntry* entry : followers()) {
    TwoBalls alone(*entry, 2, 1);
    for (int frame = 1; frame <= 6; ++frame) alone.simulation->step_frame(frame);
    for (const int threads : {2, 3}) {
      TwoBalls team(*entry, 2, threads);
      for (int frame = 1; frame <= 6; ++frame) team.simulation->step_frame(frame);
      EXPECT_EQ(team.simulation->positions(), alone.simulation->positions()) << entry->name << threads;
    }
  }
}

}  // namespace
}  // namespace musclebench

#include "core/pbd/frame_impulses.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bench/cases/tests/done_simulation.hpp"
#include "bench/cases/tests/force_scenes.hpp"

namespace musclebench {
namespace {

const std::vector<std::string> all_effects = {
    "gravity",  "damping",      "attachment",   "activation", "edge_length",
    "volume",   "bending",      "local_volume", "margin",     "tunnelling_guard",
    "friction", "self_contact", "multi_bone",   "no_passage", "surface_contact",
};

/// How far the impulses on a node are from its change of momentum in the last frame, over the largest such change.
double off_momentum(DoneSimulation& done) {
  const std::vector<Vec3> after = done.simulation().velocities();
  double largest = 0;
  double off = 0;
  for (int node = 0; node < static_cast<int>(after.size()); ++node) {
    const auto i = static_cast<std::size_t>(node);
    if (done.masses_kg[i] == 0) continue;
    const Vec3 change = done.masses_kg[i] * (after[i] - done.velocities_before[i]);
    const Vec3 sum = done.of_effects(node) + done.impulses().of_contacts(node);
    largest = std::max(largest, change.norm());
    off = std::max(off, (sum - change).norm());
  }
  EXPECT_GT(largest, 0);
  return off / largest;
}

TEST(FrameImpulses, AddUpToTheChangeOfMomentumOfEachNode) {
  DoneSimulation done(combination_scene(all_effects), true);
  EXPECT_LT(off_momentum(done), 1e-9);
}

/// Between two bones: the scene above has one end only, and no fibres.
TEST(FrameImpulses, OfFibresAddUpToo) {
  Scene scene =
      force_scenes::taut_strap("[effects.edge_length]\n[effects.fibre_force]\nrise_s = 0\npassive_strain = 0.1\n");
  scene.loop.frames = 3;
  DoneSimulation done(std::move(scene), true);
  EXPECT_LT(off_momentum(done), 1e-9);
}

TEST(FrameImpulses, AreToldByColliderWithoutARest) {
  DoneSimulation done(combination_scene(all_effects), true);
  const ContactImpulses& contacts = done.impulses().by_collider();
  std::vector<double> of_collider(contacts.colliders(), 0.0);
  for (int node = 0; node < static_cast<int>(done.masses_kg.size()); ++node) {
    Vec3 sum = Vec3::Zero();
    if (done.masses_kg[static_cast<std::size_t>(node)] == 0) continue;
    for (std::size_t collider = 0; collider < contacts.colliders(); ++collider) {
      sum += contacts.at(collider, node);
      of_collider[collider] += contacts.at(collider, node).norm();
    }
    EXPECT_LT((sum - done.impulses().of_contacts(node)).norm(), 1e-9 * (1 + sum.norm()));
  }
  EXPECT_GT(of_collider[0], 0) << "the plate";
  EXPECT_GT(of_collider[1], 0) << "the rod";
  EXPECT_GT(of_collider[2], 0) << "the ball";
  EXPECT_GT(of_collider[3], 0) << "the other ball";
}

TEST(FrameImpulses, OfInternalConstraintsAddUpToNothing) {
  DoneSimulation done(
      combination_scene({"attachment", "activation", "edge_length", "volume", "bending", "local_volume"}), true);
  for (std::size_t effect = 0; effect < done.prepared.effect_names.size(); ++effect) {
    if (done.prepared.effect_names[effect] == "attachment") continue;
    Vec3 sum = Vec3::Zero();
    double sizes = 0;
    for (int node = 0; node < static_cast<int>(done.masses_kg.size()); ++node) {
      sum += done.impulses().of_effect(effect, node);
      sizes += done.impulses().of_effect(effect, node).norm();
    }
    EXPECT_GT(sizes, 0) << done.prepared.effect_names[effect];
    EXPECT_LT(sum.norm(), 1e-12 * sizes) << done.prepared.effect_names[effect];
  }
}

TEST(FrameImpulses, BetweenMusclesAreOppositeAndEqual) {
  DoneSimulation done(combination_scene({"attachment", "edge_length", "volume", "friction"}), true);
  const ContactImpulses& contacts = done.impulses().by_collider();
  const std::vector<Body> bodies = done.scene.bodies();
  Vec3 on_ball = Vec3::Zero();
  Vec3 on_other = Vec3::Zero();
  for (int node = 0; node < bodies[1].last_node; ++node) {
    (bodies[0].has_node(node) ? on_ball : on_other) +=
        contacts.at(contacts.of_muscle(bodies[0].has_node(node) ? 1 : 0), node);
  }
  EXPECT_GT(on_ball.norm(), 0);
  EXPECT_LT((on_ball + on_other).norm(), 1e-9 * on_ball.norm());
}

TEST(FrameImpulses, ChangeNoBitOfTheMotionAndAreTheSameOnTwoThreads) {
  DoneSimulation without(combination_scene(all_effects), false);
  DoneSimulation with(combination_scene(all_effects), true);
  DoneSimulation on_two(combination_scene(all_effects), true, 2);
  EXPECT_EQ(without.simulation().positions(), with.simulation().positions());
  EXPECT_EQ(on_two.simulation().positions(), with.simulation().positions());
  for (int node = 0; node < static_cast<int>(with.masses_kg.size()); ++node) {
    EXPECT_EQ(on_two.impulses().of_contacts(node), with.impulses().of_contacts(node));
    EXPECT_EQ(on_two.of_effects(node), with.of_effects(node));
  }
}

}  // namespace
}  // namespace musclebench

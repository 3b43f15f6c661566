#include "core/pbd/start_overlap.hpp"

#include <gtest/gtest.h>

#include "core/pbd/simulation.hpp"

namespace musclebench {
namespace {

/// z < 0 of a bone that rises by `rise_m` a frame, answered exactly.
class Ground final : public CollisionBackend {
 public:
  bool misses = false;

  [[nodiscard]] Capabilities capabilities() const override { return {}; }
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override { return {}; }
  [[nodiscard]] std::size_t structure_bytes() const override { return 0; }
  [[nodiscard]] double step_m(int /*bone*/) const override { return 1e-4; }

 private:
  void do_build() override {}
  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    for (const int node : nodes) {
      const double height_m = poses()[0].apply_inverse(positions[static_cast<std::size_t>(node)]).z();
      if (height_m < 0 && !misses) contacts.push_back({node, 0, -height_m, Vec3::UnitZ()});
    }
  }
};

struct Setting {
  double height_m = 0;
  double speed_m_per_s = 0;  ///< upwards
  double depenetration_m_per_s = 0;
  double rise_m_per_frame = 0;
};

constexpr double step_s = 1e-3;

class Node {
 public:
  explicit Node(const Setting& setting) {
    m_backend.build(m_bones, {}, 1);
    Particles particles;
    particles.positions = {Vec3(0, 0, setting.height_m)};
    particles.velocities = {Vec3(0, 0, setting.speed_m_per_s)};
    particles.inverse_masses = {1};
    m_simulation = std::make_unique<Simulation>(
        LoopParameters{.depenetration_m_per_s = setting.depenetration_m_per_s, .time_step_s = step_s}, particles,
        NodeOrder(particles.positions, std::vector<Body>{{"a", 0, 1}}), std::vector<std::unique_ptr<Effect>>(),
        m_backend, ResponseKind::project,
        [rise_m = setting.rise_m_per_frame](double at, std::vector<RigidMotion>& poses) {
          poses.assign(1, RigidMotion{Mat3::Identity(), Vec3(0, 0, rise_m * at)});
        });
  }
  void miss(bool misses) { m_backend.misses = misses; }
  void step() { m_simulation->step_frame(++m_frame); }
  [[nodiscard]] double height_m() const { return m_simulation->positions()[0].z(); }
  [[nodiscard]] double speed_m_per_s() const { return m_simulation->velocities()[0].z(); }

 private:
  std::vector<Bone> m_bones{1};
  Ground m_backend;
  std::unique_ptr<Simulation> m_simulation;
  int m_frame = 0;
};

TEST(StartOverlap, IsLaidOutSlowlyAndTakesUpNoSpeed) {
  Node node({.height_m = -0.00105, .depenetration_m_per_s = 0.1});
  for (int step = 1; step <= 10; ++step) {
    node.step();
    EXPECT_NEAR(node.height_m(), -0.00105 + step * 1e-4, 1e-15);
    EXPECT_NEAR(node.speed_m_per_s(), 0, 1e-12);
  }
  for (int step = 0; step < 3; ++step) node.step();
  EXPECT_NEAR(node.height_m(), 0, 1e-15);
  EXPECT_NEAR(node.speed_m_per_s(), 0, 1e-12);
}

/// As the paper's loop does.
TEST(StartOverlap, IsThrownOutWithoutALimit) {
  Node node({.height_m = -0.001});
  node.step();
  EXPECT_EQ(node.height_m(), 0);
  EXPECT_NEAR(node.speed_m_per_s(), 1, 1e-12);
}

TEST(StartOverlap, LosesTheSpeedItComesInWith) {
  Node node({.height_m = -0.001, .speed_m_per_s = -0.3, .depenetration_m_per_s = 0.1});
  node.step();
  EXPECT_NEAR(node.height_m(), -0.001 + 1e-4, 1e-15);
  EXPECT_NEAR(node.speed_m_per_s(), 0, 1e-12);
}

TEST(StartOverlap, IsCarriedByABoneThatMoves) {
  Node node({.height_m = -0.001, .depenetration_m_per_s = 0.1, .rise_m_per_frame = 5e-4});
  node.step();
  EXPECT_NEAR(node.height_m(), -0.001 + 5e-4 + 1e-4, 1e-15);
  EXPECT_NEAR(node.speed_m_per_s(), 0.5, 1e-12);
}

/// It began outside, and so it is stopped at the surface whatever the limit.
TEST(StartOverlap, IsNotWhatComesInLater) {
  for (const double height_m : {0.0005, 0.0, 1e-19}) {
    Node node({.height_m = height_m, .speed_m_per_s = -1, .depenetration_m_per_s = 0.1});
    node.step();
    EXPECT_NEAR(node.height_m(), 0, 1e-15);
    EXPECT_LE(node.speed_m_per_s(), 1e-9);
  }
}

/// As FCL misses nodes deep in a bone.
TEST(StartOverlap, IsNotThrownByABackendThatMissedItOnce) {
  Node node({.height_m = -0.00105, .depenetration_m_per_s = 0.1});
  for (int step = 1; step <= 9; ++step) {
    node.miss(step == 4);
    node.step();
    EXPECT_NEAR(node.speed_m_per_s(), 0, 1e-12) << step;
  }
}

TEST(StartOverlap, DoesNotHoldANodeThatLeavesByItself) {
  Node node({.height_m = -0.0001, .speed_m_per_s = 0.5, .depenetration_m_per_s = 0.01, .rise_m_per_frame = 0});
  node.step();  // by its own speed it is out
  EXPECT_NEAR(node.height_m(), 0.0004, 1e-15);
  EXPECT_NEAR(node.speed_m_per_s(), 0.5, 1e-12);
}

}  // namespace
}  // namespace musclebench

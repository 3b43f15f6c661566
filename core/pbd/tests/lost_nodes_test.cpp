#include "core/pbd/lost_nodes.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/pbd/simulation.hpp"

namespace musclebench {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

NodeRow row_at(const Vec3& position) {
  NodeRow row;
  row.set_position(position);
  return row;
}

/// The quick comparison must leave none out, along the axes and between them.
/// As the loop does.
void look_at(LostNodes& lost, int node, const NodeRow& position, const NodeRow& move = {}) {
  if (!lost.is_near(position)) lost.measure_position(node, position.position());
  if (!lost.is_small(move)) lost.measure_move(node, move.position());
}

TEST(LostNodes, AreThoseFartherFromTheirStartThanTheRange) {
  const std::vector<Vec3> start = {Vec3(5, 5, 5), Vec3(6, 5, 5), Vec3(5, 7, 4)};
  LostNodes lost(start);
  lost.set_limits({.range_m = 10});
  for (int node = 0; node < 3; ++node) {
    for (const Vec3& towards : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(1, 1, 1), Vec3(-1, 1, -1), Vec3(-1, -2, 0)}) {
      const auto at = [&](double distance_m) -> Vec3 {
        return start[static_cast<std::size_t>(node)] + distance_m * towards.normalized();
      };
      lost.clear();
      look_at(lost, node, row_at(at(9.99)));
      EXPECT_FALSE(lost.any()) << towards.transpose();
      look_at(lost, node, row_at(at(10.01)));
      EXPECT_EQ(lost.first(), node) << towards.transpose();
    }
  }
}

TEST(LostNodes, AreThoseWithoutANumber) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double bad : {not_a_number, std::numeric_limits<double>::infinity()}) {
      LostNodes lost(std::vector<Vec3>(1, Vec3::Zero()));
      lost.set_limits({.range_m = 1, .move_m = 1});
      Vec3 position = Vec3::Zero();
      position[axis] = bad;
      look_at(lost, 0, row_at(position));
      EXPECT_EQ(lost.first(), 0);
      lost.clear();
      look_at(lost, 0, {}, row_at(position));
      EXPECT_EQ(lost.first(), 0);
    }
  }
}

TEST(LostNodes, TheFirstByItsNumberIsTold) {
  LostNodes lost(std::vector<Vec3>(4, Vec3::Zero()));
  lost.set_limits({.range_m = 1});
  for (const int node : {3, 1, 2}) look_at(lost, node, row_at(Vec3(0, 2, 0)));
  EXPECT_EQ(lost.first(), 1);
}

/// Knows no bone; counts how often it is asked.
class NoBones final : public CollisionBackend {
 public:
  int detections = 0;

  [[nodiscard]] Capabilities capabilities() const override { return {}; }
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override { return {}; }
  [[nodiscard]] std::size_t structure_bytes() const override { return 0; }
  [[nodiscard]] double step_m(int /*bone*/) const override { return 0.125; }

 private:
  void do_build() override {}
  void do_detect(std::span<const Vec3> /*positions*/, std::span<const int> /*nodes*/,
                 std::vector<Contact>& /*contacts*/) override {
    ++detections;
  }
};

/// Moves node 1 by `by_m` in one substep, and back in the next.
class Kick final : public Effect {
 public:
  Kick(int substep, double by_m) : m_substep(substep), m_by_m(by_m) {}
  [[nodiscard]] std::string_view name() const override { return "kick"; }
  void project(NodeRows& rows, const SubstepInput& /*input*/, const Team& team) override {
    if (!team.is_first()) return;
    ++m_calls;
    if (m_calls == m_substep) rows[1].x += m_by_m;
    if (m_calls == m_substep + 1) rows[1].x -= 2 * m_by_m;
  }

 private:
  int m_substep;
  double m_by_m;
  int m_calls = 0;
};

class LostInTheLoop : public testing::TestWithParam<int> {
 protected:
  std::unique_ptr<Simulation> kicked(double by_m, int threads) {
    m_backend.build({}, {}, 1);
    Particles particles;
    for (int i = 0; i < 100; ++i) particles.positions.emplace_back(0.001 * i, 0, 0);
    particles.velocities.assign(100, Vec3::Zero());
    particles.inverse_masses.assign(100, 1);
    NodeOrder order(particles.positions, std::vector<Body>{{"a", 0, 100}});
    std::vector<std::unique_ptr<Effect>> effects;
    effects.push_back(std::make_unique<Kick>(7, by_m));
    auto made = std::make_unique<Simulation>(
        LoopParameters{.substeps = 20, .time_step_s = 0.01}, particles, std::move(order), std::move(effects), m_backend,
        ResponseKind::project, [](double, std::vector<RigidMotion>& poses) { poses.clear(); }, threads);
    made->limit_motion({.range_m = 10, .move_m = 1});
    return made;
  }

  NoBones m_backend;
};

TEST_P(LostInTheLoop, TheFrameEndsBeforeTheCollisionsOfANodeThatIsThrown) {
  const auto simulation = kicked(1.1, GetParam());
  simulation->step_frame(1);
  EXPECT_EQ(simulation->substep(), 8);
  EXPECT_EQ(m_backend.detections, 7);
  EXPECT_EQ(simulation->lost().first(), 1);
  EXPECT_FALSE(simulation->lost().is_out_of_range(1, simulation->predicted(1)));
}

TEST_P(LostInTheLoop, AMoveWithinTheLimitIsNone) {
  const auto simulation = kicked(0.4, GetParam());
  simulation->step_frame(1);
  EXPECT_EQ(simulation->substep(), 20);
  EXPECT_FALSE(simulation->lost().any());
}

/// A response that goes back cell by cell from there would never end.
TEST_P(LostInTheLoop, NoContactIsSoughtOfANodeThatHasLeftTheScene) {
  const auto simulation = kicked(1e30, GetParam());
  simulation->step_frame(1);
  EXPECT_EQ(simulation->substep(), 7);
  EXPECT_EQ(m_backend.detections, 6);
  EXPECT_TRUE(simulation->lost().is_out_of_range(1, simulation->predicted(1)));
  EXPECT_EQ(simulation->positions()[1].x(), 0.001);  // of the last whole substep
}

TEST_P(LostInTheLoop, AStoppedFrameEndsBeforeItsNextDetection) {
  const auto simulation = kicked(0, GetParam());
  int asked = 0;
  simulation->stop_when([&] { return ++asked == 12; });
  simulation->step_frame(1);
  EXPECT_TRUE(simulation->was_stopped());
  EXPECT_EQ(simulation->substep(), 12);
  EXPECT_EQ(m_backend.detections, 11);
}

INSTANTIATE_TEST_SUITE_P(Threads, LostInTheLoop, testing::Values(1, 3));

}  // namespace
}  // namespace musclebench

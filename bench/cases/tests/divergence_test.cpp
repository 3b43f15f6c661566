#include "bench/cases/divergence.hpp"

#include <gtest/gtest.h>

#include "bench/cases/kept_steps.hpp"
#include "bench/cases/run_case.hpp"
#include "bench/cases/tests/bar_and_ball.hpp"

namespace musclebench {
namespace {

/// A ball above a plate.
RunResult run_ball(const std::string& effects, const std::string& loop, const std::function<bool()>& is_stopped = {}) {
  const Scene scene = read_scene(bar_and_ball::request("[loop]\n" + loop + effects +
                                                       "[[bone]]\nname = \"plate\"\nmesh = \"synthetic:plate\"\n"
                                                       "[[muscle]]" +
                                                       std::string(bar_and_ball::ball)));
  const BackendEntry& backend = find_backend("null");
  return run_case(
      {{scene, backend, Parameters(backend.parameters, {}, "test")}}, [](int) {}, {}, is_stopped);
}

/// Gravity is a force: what carries a node out of the scene is the velocity that it made. 2.5 m are 3.6 s of falling,
/// some 36 steps of 0.1 s.
TEST(Divergence, IsSeenInItsSubstepAndNamedByWhatMovedTheNode) {
  const RunResult fallen = run_ball("[effects.gravity]\n", "frames = 5\ntime_step_s = 0.01\nsubsteps = 1000\n");
  EXPECT_EQ(fallen.status, "diverged");
  EXPECT_NE(fallen.status_detail.find(" left the scene by more than 2.0"), std::string::npos) << fallen.status_detail;
  EXPECT_NE(fallen.status_detail.find("moved out by its own velocity"), std::string::npos) << fallen.status_detail;
  int substep = 0;
  ASSERT_EQ(std::sscanf(fallen.status_detail.c_str(), "frame 1, substep %d:", &substep), 1) << fallen.status_detail;
  // Of g t^2 / 2, t = n h, semi-implicit: g h^2 n (n + 1) / 2 = 10 diagonals.
  const double fallen_m = 9.80665 * 1e-4 * substep * (substep + 1) / 2;
  const double before_m = 9.80665 * 1e-4 * (substep - 1) * substep / 2;
  double range_m = 0;
  ASSERT_EQ(std::sscanf(fallen.status_detail.substr(fallen.status_detail.find("more than")).c_str(), "more than %lf m",
                        &range_m),
            1);
  EXPECT_GT(fallen_m, 0.99 * range_m);
  EXPECT_LT(before_m, 1.01 * range_m);
  EXPECT_EQ(fallen.records.size(), 1U);
}

/// Throws node 5 in the third substep of the second frame.
class Thrower final : public ContactStage {
 public:
  [[nodiscard]] std::string_view name() const override { return "thrower"; }
  std::span<const int> after_bones(const ContactStageInput& input) override {
    if (++m_calls == 7) input.predicted[5].x() += 1e6;
    return m_moved;
  }
  [[nodiscard]] int contact_count() const override { return 0; }

 private:
  int m_calls = 0;
  std::vector<int> m_moved = {5};
};

/// Comes after it and moves nothing.
class Bystander final : public ContactStage {
 public:
  [[nodiscard]] std::string_view name() const override { return "bystander"; }
  [[nodiscard]] int contact_count() const override { return 0; }
};

TEST(Divergence, AContactStageIsNamed) {
  const Scene scene =
      read_scene(bar_and_ball::request("[loop]\nframes = 3\nsubsteps = 4\n[[bone]]\nname = \"plate\"\n"
                                       "mesh = \"synthetic:plate\"\n[[muscle]]" +
                                       std::string(bar_and_ball::ball)));
  const BackendEntry& entry = find_backend("null");
  const auto backend = make_backend(scene, entry, Parameters(entry.parameters, {}, "test"), {});
  backend->build(scene.bones, scene.muscle_mesh, 1);
  const auto prepared = [&] {
    PreparedSimulation made = prepare_simulation(scene, *backend, {ResponseKind::project}, 1);
    made.simulation->add_stage(std::make_unique<Thrower>());
    made.simulation->add_stage(std::make_unique<Bystander>());
    return made;
  };
  const PreparedSimulation run = prepared();
  run.simulation->step_frame(1);
  EXPECT_EQ(describe_divergence(*run.simulation, 1), "");
  run.simulation->step_frame(2);
  const std::string words = describe_divergence(*run.simulation, 2);
  EXPECT_EQ(words.find("frame 2, substep 3: node 5 left the scene by more than "), 0U) << words;
  const PreparedSimulation again = prepared();
  KeptSteps steps(false);
  EXPECT_EQ(cause_of_divergence(*again.simulation, 2, steps), "thrower");
  EXPECT_EQ(steps.take().size(), 4U);
}

TEST(Divergence, ARunIsStoppedInsideAFrameAndKeepsTheRowsBefore) {
  int asked = 0;
  const RunResult stopped =
      run_ball("", "frames = 3\ntime_step_s = 0.001\nsubsteps = 1000\n", [&] { return ++asked >= 1500; });
  EXPECT_EQ(stopped.status, "interrupted");
  EXPECT_EQ(stopped.status_detail, "in frame 2 of 3, substep 499 of 1000");  // asked once between the frames
  EXPECT_EQ(stopped.records.size(), 1U);
}

}  // namespace
}  // namespace musclebench

#include "bench/cases/replay_case.hpp"

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "bench/cases/kept_frames.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

/// Writes down what it is told and asked: each call with the first node's x.
class ListeningBackend final : public CollisionBackend {
 public:
  ListeningBackend(bool has_cache, std::vector<std::string>& calls) : m_has_cache(has_cache), m_calls(calls) {}

  [[nodiscard]] Capabilities capabilities() const override { return {.has_cache = m_has_cache}; }
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override { return {}; }
  [[nodiscard]] std::size_t structure_bytes() const override { return 0; }

 private:
  void do_build() override {}
  void do_update(std::span<const Vec3> positions) override {
    m_calls.push_back(fmt::format("update {}", positions[0].x()));
  }
  void do_detect(std::span<const Vec3> positions, std::span<const int> /*nodes*/,
                 std::vector<Contact>& /*contacts*/) override {
    m_calls.push_back(fmt::format("detect {}", positions[0].x()));
  }

  bool m_has_cache;
  std::vector<std::string>& m_calls;
};

/// Frames 7 and 8 with a step each, at x = 7 and 8; before them a frame of which two steps lead in, at 5 and 6.
class ReplayOfKeptFrames : public testing::Test {
 protected:
  ReplayOfKeptFrames() : m_frames(static_cast<int>(m_muscle.vertices.size()), m_nodes) {
    m_scene.bones.push_back({"ball", {m_muscle, true, {}}});
    m_scene.add_muscle("muscle", m_muscle);
    m_frames.begin_lead_in();
    observe(5);
    observe(6);
    m_frames.begin_frame(7, 0);
    observe(7);
    m_frames.begin_frame(8, 0);
    observe(8);
  }

  std::vector<std::string> calls_of_replay(bool has_cache, int stride = 1) {
    std::vector<std::string> calls;
    replay(calls, has_cache, stride, 2);
    return calls;
  }

  /// Whether each replayed frame is marked.
  std::vector<bool> warm_up_of_replay(int warm_up_frames, int stride = 1) {
    std::vector<std::string> calls;
    std::vector<bool> marked;
    for (const ReplayRecord& record : replay(calls, false, stride, warm_up_frames).records) {
      marked.push_back(record.warm_up);
    }
    return marked;
  }

 private:
  ReplayResult replay(std::vector<std::string>& calls, bool has_cache, int stride, int warm_up_frames) {
    const BackendEntry entry{.name = "listening", .help = "", .make = [&](const Parameters& /*none*/) {
                               return std::make_unique<ListeningBackend>(has_cache, calls);
                             }};
    ReplayCase replay{{m_scene, entry, Parameters({}, {}, entry.name)}};
    replay.judge = false;
    replay.stride = stride;
    replay.warm_up_frames = warm_up_frames;
    ReplayResult result = replay_case(replay, m_frames, [](int /*done*/) {});
    EXPECT_EQ(result.status, "ok");
    return result;
  }

  void observe(double x) {
    std::vector<Vec3> positions = m_muscle.vertices;
    positions[0].x() = x;
    const std::vector<RigidMotion> poses(1);
    m_frames.before_detection({positions, poses, positions, poses});
  }

  TriangleMesh m_muscle = make_sphere(0.1, 0);
  std::vector<int> m_nodes{0, 1, 2};
  Scene m_scene;
  KeptFrames m_frames;
};

TEST_F(ReplayOfKeptFrames, LeadsInByTheLastStepBeforeAGap) {
  const std::vector<std::string> expected{"update 6", "update 7", "detect 7", "update 8", "detect 8"};
  EXPECT_EQ(calls_of_replay(false), expected);
}

TEST_F(ReplayOfKeptFrames, ABackendThatRemembersIsAskedAboutThatStep) {
  const std::vector<std::string> expected{"update 6", "detect 6", "update 7", "detect 7", "update 8", "detect 8"};
  EXPECT_EQ(calls_of_replay(true), expected);
  EXPECT_EQ(calls_of_replay(true), expected) << "the second time";
}

TEST_F(ReplayOfKeptFrames, AFrameThatTheStrideLeavesOutLeadsInToo) {
  const std::vector<std::string> expected{"update 7", "detect 7", "update 8", "detect 8"};
  EXPECT_EQ(calls_of_replay(true, 2), expected);
}

TEST_F(ReplayOfKeptFrames, TheFirstOfThoseReplayedAreWarmUp) {
  EXPECT_EQ(warm_up_of_replay(0), (std::vector<bool>{false, false}));
  EXPECT_EQ(warm_up_of_replay(1), (std::vector<bool>{true, false}));
  EXPECT_EQ(warm_up_of_replay(2), (std::vector<bool>{true, true}));
  EXPECT_EQ(warm_up_of_replay(1, 2), (std::vector<bool>{true}));
}

/// Answers about every node the same, and declares `bound`.
class Stubborn final : public CollisionBackend {
 public:
  Stubborn(AnswerBound bound, bool finds) : m_bound(bound), m_finds(finds) {}

  [[nodiscard]] Capabilities capabilities() const override { return {}; }
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override { return m_bound; }
  [[nodiscard]] std::size_t structure_bytes() const override { return 0; }

 private:
  void do_build() override {}
  void do_detect(std::span<const Vec3> /*positions*/, std::span<const int> nodes,
                 std::vector<Contact>& contacts) override {
    for (const int node : nodes) {
      if (m_finds) contacts.push_back({node, 0, 0.001, Vec3::UnitX()});
    }
  }

  AnswerBound m_bound;
  bool m_finds;
};

/// A replay of one step, in which all nodes lie at `share` of the ball's radius.
ReplayResult replay_of_ball(double share, AnswerBound bound, bool finds) {
  const TriangleMesh ball = make_sphere(0.1, 1);
  Scene scene;
  scene.bones.push_back({"ball", {ball, true, {}}});
  scene.add_muscle("muscle", ball);
  const std::vector<int> nodes{0, 1, 2, 3};
  KeptFrames frames(static_cast<int>(ball.vertices.size()), nodes);
  std::vector<Vec3> positions = ball.vertices;
  for (Vec3& position : positions) position *= share;
  const std::vector<RigidMotion> poses(1);
  frames.begin_frame(1, 0);
  frames.before_detection({positions, poses, positions, poses});
  const BackendEntry entry{.name = "stubborn", .help = "", .make = [&](const Parameters& /*none*/) {
                             return std::make_unique<Stubborn>(bound, finds);
                           }};
  return replay_case({{scene, entry, Parameters({}, {}, entry.name)}}, frames, [](int /*done*/) {});
}

TEST(Replay, IsSuspectWhereAnAnswerIsOffByMoreThanIsDeclared) {
  const ReplayResult missed = replay_of_ball(0.5, {0.01, 0.01}, false);
  EXPECT_EQ(missed.status, "suspect");
  EXPECT_NE(missed.status_detail.find("stubborn missed a contact "), std::string::npos) << missed.status_detail;
  EXPECT_NE(missed.status_detail.find("declares none deeper than 10 mm"), std::string::npos) << missed.status_detail;
  const ReplayResult false_one = replay_of_ball(1.5, {0.01, 0.01}, true);
  EXPECT_EQ(false_one.status, "suspect");
  EXPECT_NE(false_one.status_detail.find("declares none farther than 10 mm"), std::string::npos)
      << false_one.status_detail;
}

TEST(Replay, IsOkWhereTheBackendDeclaresSoMuchOrNothing) {
  const double unknown_m = std::numeric_limits<double>::infinity();
  EXPECT_EQ(replay_of_ball(0.5, {0.06, 0}, false).status, "ok");
  EXPECT_EQ(replay_of_ball(0.5, {unknown_m, unknown_m}, false).status, "ok");
  EXPECT_EQ(replay_of_ball(1.5, {0, 0.06}, true).status, "ok");
  EXPECT_EQ(replay_of_ball(1.5, {0, 0}, false).status, "ok");
}

}  // namespace
}  // namespace musclebench

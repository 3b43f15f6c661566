// Contact between muscles in a replay: what is asked, and how answers are compared with the truth.
#include "bench/cases/muscle_replay.hpp"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "bench/cases/kept_frames.hpp"
#include "bench/cases/replay_case.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

TriangleMesh ball_at(double x_m) {
  TriangleMesh mesh = make_sphere(0.02, 3);
  for (Vec3& vertex : mesh.vertices) vertex.x() += x_m;
  return mesh;
}

/// Two balls that come nearer and part again, and a bone far away. Frames 3 and 4 with two steps each, after one that
/// leads in.
struct PassingBalls {
  Scene scene;
  std::unique_ptr<KeptFrames> frames;

  PassingBalls() {
    scene.bones.push_back({"far", {ball_at(1), true, {}}});
    scene.add_muscle("left", ball_at(0));
    scene.add_muscle("right", ball_at(0.039));
    scene.muscle_pairs = {{{0, 1}}};
    const std::vector<int> nodes(1, 0);
    frames = std::make_unique<KeptFrames>(static_cast<int>(scene.muscle_mesh.vertices.size()), nodes, true);
    frames->begin_lead_in();
    observe(-0.0005);
    frames->begin_frame(3, 30);
    observe(0.001);
    observe(0.002);
    frames->begin_frame(4, 40);
    observe(0.0005);
    observe(-0.003);
  }

  /// The right ball comes so near; p after the stages is far from that.
  void observe(double nearer_m) const {
    std::vector<Vec3> positions = scene.muscle_mesh.vertices;
    const Body& right = scene.muscles[1].body;
    for (int node = right.first_node; node < right.last_node; ++node) {
      positions[static_cast<std::size_t>(node)].x() -= nearer_m;
    }
    const std::vector<Vec3> elsewhere(positions.size(), Vec3(0, 0, 9));
    const std::vector<RigidMotion> poses(1);
    frames->before_stages(positions);
    frames->before_detection({elsewhere, poses, elsewhere, poses});
  }

  [[nodiscard]] ReplayResult replay(const BackendEntry& between, bool judge = true, int stride = 1) const {
    const BackendEntry& none = find_backend("null");
    ReplayCase replay{{scene, none, Parameters(none.parameters, {}, "test")}};
    replay.colliders.of_muscle_pairs = {{&between, Parameters(between.parameters, {}, "test")}};
    replay.judge = judge;
    replay.stride = stride;
    replay.warm_up_frames = 1;
    int done = 0;
    ReplayResult result = replay_case(replay, *frames, [&](int frames_done) { EXPECT_EQ(frames_done, ++done); });
    EXPECT_EQ(done, replayed_frames(replay, frames->header()));
    return result;
  }
};

TEST(MuscleReplay, EveryDetectorIsAskedAboutTheSameAndJudged) {
  const PassingBalls balls;
  std::vector<std::string> hashes;
  for (const BackendEntry& entry : backend_registry()) {
    if (!entry.make_muscle_detector) continue;
    const ReplayResult result = balls.replay(entry);
    EXPECT_EQ(result.status, "ok") << entry.name;
    ASSERT_TRUE(result.muscles) << entry.name;
    const MuscleReplay& muscles = *result.muscles;
    ASSERT_EQ(muscles.records.size(), 2U);
    ASSERT_EQ(muscles.accuracy.size(), 1U);
    EXPECT_EQ(muscles.records[0].frame, 3);
    EXPECT_EQ(muscles.records[0].angle_deg, 30);
    EXPECT_TRUE(muscles.records[0].warm_up);
    EXPECT_FALSE(muscles.records[1].warm_up);
    long contacts = 0;
    for (const MuscleReplayRecord& record : muscles.records) {
      EXPECT_EQ(record.iterations, 2);
      ASSERT_EQ(record.pairs.size(), 1U);
      const PairReplay& pair = record.pairs[0];
      EXPECT_EQ(pair.muscle, "left");
      EXPECT_EQ(pair.other, "right");
      EXPECT_EQ(pair.backend, entry.name);
      EXPECT_GT(pair.detect_ns, 0);
      EXPECT_GE(pair.backend_ns, pair.detect_ns);
      ASSERT_TRUE(pair.accuracy);
      EXPECT_EQ(pair.accuracy->contacts, pair.contacts);
      EXPECT_EQ(pair.accuracy->false_contacts, 0) << entry.name;
      contacts += pair.contacts;
    }
    EXPECT_EQ(muscles.accuracy[0].contacts, contacts);
    EXPECT_GT(muscles.accuracy[0].true_contacts, 20);
    if (entry.exact || entry.name == "brute_force") {
      EXPECT_EQ(muscles.accuracy[0].missed_contacts, 0);
      EXPECT_LT(muscles.accuracy[0].depth_error_m->max, 1e-15);
      hashes.push_back(muscles.contact_hash);
    }
  }
  ASSERT_GE(hashes.size(), 2U);
  EXPECT_EQ(std::ranges::count(hashes, hashes[0]), std::ssize(hashes));
}

/// The first contact is missing, one stands there that is none, and the others are a tenth of a millimetre too deep.
class WrongDetector final : public MuscleContactDetector {
 public:
  WrongDetector(std::unique_ptr<MuscleContactDetector> right, std::vector<double>& asked, bool moody)
      : m_right(std::move(right)), m_asked(asked), m_moody(moody) {}

  void detect(std::span<const Vec3> positions, std::vector<MuscleContact>& contacts) override {
    m_asked.push_back(positions.back().x());
    m_right->detect(positions, contacts);
    if (contacts.empty()) return;
    MuscleContact none = contacts.front();
    contacts.erase(contacts.begin());
    for (MuscleContact& contact : contacts) contact.depth_m += 1e-4;
    none.node = 0;
    while (std::ranges::find(contacts, none.node, &MuscleContact::node) != contacts.end()) ++none.node;
    none.depth_m = m_moody ? static_cast<double>(m_asked.size()) : 0;
    contacts.insert(contacts.begin(), none);
  }
  [[nodiscard]] std::span<const PairTime> pair_times() const override { return m_right->pair_times(); }
  [[nodiscard]] std::size_t structure_bytes() const override { return 7; }

 private:
  std::unique_ptr<MuscleContactDetector> m_right;
  std::vector<double>& m_asked;
  bool m_moody;
};

BackendEntry wrong_entry(std::vector<double>& asked, bool moody = false) {
  return {
      .name = "wrong",
      .help = "",
      .make_muscle_detector = [&asked, moody](const Parameters& /*none*/, const TouchingMuscles& muscles, int threads) {
        const BackendEntry& right = find_backend("bvh");
        return std::make_unique<WrongDetector>(
            right.make_muscle_detector(Parameters(right.parameters, {}, "test"), muscles, threads), asked, moody);
      }};
}

TEST(MuscleReplay, WhatIsMissedFalseOrOfAnotherDepthIsCounted) {
  const PassingBalls balls;
  std::vector<double> asked;
  const ReplayResult result = balls.replay(wrong_entry(asked));
  const Accuracy& accuracy = result.muscles->accuracy[0];
  EXPECT_EQ(result.muscles->structure_bytes, 7U);
  EXPECT_EQ(accuracy.missed_contacts, 3);  // in three of four steps the balls touch
  EXPECT_EQ(accuracy.false_contacts, 3);
  EXPECT_EQ(accuracy.contacts, accuracy.true_contacts);
  EXPECT_GT(accuracy.max_missed_depth_m, 0);
  // Of the left ball's first node from the right ball where that is farthest.
  const double apart_m = (balls.scene.muscle_mesh.vertices[0] - Vec3(0.0385, 0, 0)).norm() - 0.02;
  EXPECT_NEAR(accuracy.max_false_distance_m, apart_m, 3e-4);  // it has flat faces
  // What both see is wrong by what was added; missed and false contacts are counted only.
  EXPECT_NEAR(accuracy.depth_error_m->max, 1e-4, 1e-12);
  EXPECT_NEAR(accuracy.depth_error_m->mean, 1e-4, 1e-12);
  EXPECT_EQ(accuracy.measured_contacts, accuracy.true_contacts - accuracy.missed_contacts);
}

TEST(MuscleReplay, ADetectorIsLedInByTheStepBeforeAGap) {
  const PassingBalls balls;
  std::vector<double> asked;
  (void)balls.replay(wrong_entry(asked), false);
  ASSERT_EQ(asked.size(), 5U);
  const double at_rest_m = balls.scene.muscle_mesh.vertices.back().x();
  const double expected[] = {-0.0005, 0.001, 0.002, 0.0005, -0.003};
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(asked[i], at_rest_m - expected[i]) << i;
  asked.clear();
  (void)balls.replay(wrong_entry(asked), false, 2);
  ASSERT_EQ(asked.size(), 3U);
  EXPECT_EQ(asked[0], at_rest_m - 0.002);
}

TEST(MuscleReplay, ADetectorThatAnswersOtherwiseTheSecondTimeIsTold) {
  const PassingBalls balls;
  std::vector<double> asked;
  EXPECT_EQ(balls.replay(wrong_entry(asked)).status, "ok");
  const ReplayResult result = balls.replay(wrong_entry(asked, true));
  EXPECT_EQ(result.status, "nondeterministic");
  EXPECT_NE(result.status_detail.find("between muscles"), std::string::npos);
}

TEST(MuscleReplay, IsLeftOutWhereNoneTouchOrTheRecordingDoesNotTell) {
  PassingBalls balls;
  const BackendEntry& none = find_backend("null");
  ReplayCase replay{{balls.scene, none, Parameters(none.parameters, {}, "test")}};
  EXPECT_FALSE(replay_case(replay, *balls.frames, [](int) {}).muscles);
  replay.colliders = choose_collider_backends({}, balls.scene, none);
  EXPECT_TRUE(replays_muscles(replay, balls.frames->header()));
  RecordingHeader untold = balls.frames->header();
  untold.muscle_contact = false;
  EXPECT_FALSE(replays_muscles(replay, untold));
}

}  // namespace
}  // namespace musclebench

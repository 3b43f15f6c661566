#include "core/recording/step_codec.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

RecordingHeader header_for(int nodes, int iterations) {
  RecordingHeader header;
  header.nodes = nodes;
  header.bones = 2;
  header.substeps = 2;
  header.iterations = iterations;
  header.rounding_m = rounding_step_m(0.5);
  return header;
}

RecordedStep random_step(std::mt19937& random, int nodes, double size_m) {
  std::uniform_real_distribution<double> coordinate(-size_m, size_m);
  const auto point = [&] { return Vec3(coordinate(random), coordinate(random), coordinate(random)); };
  RecordedStep step;
  for (int i = 0; i < nodes; ++i) {
    step.substep_start.push_back(point());
    step.positions.push_back(step.substep_start.back() + 1e-4 * point());
  }
  for (int bone = 0; bone < 2; ++bone) {
    step.previous_bone_poses.push_back(RigidMotion::about_axis(Vec3::UnitX(), point(), coordinate(random)));
    step.bone_poses.push_back(RigidMotion::about_axis(Vec3::UnitZ(), point(), coordinate(random)));
  }
  return step;
}

bool encode(StepEncoder& encoder, const RecordedStep& step, std::string& bytes) {
  return encoder.encode(step.substep_start, step.previous_bone_poses, step.positions, step.bone_poses, bytes,
                        step.muscle_positions);
}

Vec3 rounded(const Vec3& point, double rounding_m) {
  return (point / rounding_m).unaryExpr([](double x) { return std::nearbyint(x); }) * rounding_m;
}

/// Within a substep every step has the start and the poses of the first.
std::vector<RecordedStep> random_steps(int nodes, int iterations, double size_m) {
  std::mt19937 random(7);
  std::vector<RecordedStep> steps;
  for (int i = 0; i < 5 * iterations; ++i) {
    RecordedStep step = random_step(random, nodes, size_m);
    if (i % iterations != 0) {
      step.substep_start = steps.back().substep_start;
      step.previous_bone_poses = steps.back().previous_bone_poses;
      step.bone_poses = steps.back().bone_poses;
    }
    steps.push_back(step);
  }
  return steps;
}

void expect_same(const RecordedStep& step, const RecordedStep& decoded, double rounding_m) {
  ASSERT_EQ(decoded.positions.size(), step.positions.size());
  ASSERT_EQ(decoded.substep_start.size(), step.substep_start.size());
  for (std::size_t i = 0; i < step.positions.size(); ++i) {
    EXPECT_EQ(decoded.positions[i], rounded(step.positions[i], rounding_m));
    EXPECT_EQ(decoded.substep_start[i], rounded(step.substep_start[i], rounding_m));
  }
  ASSERT_EQ(decoded.bone_poses.size(), step.bone_poses.size());
  for (std::size_t i = 0; i < step.bone_poses.size(); ++i) {
    EXPECT_EQ(decoded.bone_poses[i].rotation, step.bone_poses[i].rotation);
    EXPECT_EQ(decoded.bone_poses[i].translation_m, step.bone_poses[i].translation_m);
    EXPECT_EQ(decoded.previous_bone_poses[i].rotation, step.previous_bone_poses[i].rotation);
    EXPECT_EQ(decoded.previous_bone_poses[i].translation_m, step.previous_bone_poses[i].translation_m);
  }
}

class StepCodec : public testing::TestWithParam<std::tuple<int, double>> {};

TEST_P(StepCodec, GivesTheRoundedPositionsAndTheVeryPoses) {
  const auto [iterations, size_m] = GetParam();
  const RecordingHeader header = header_for(11, iterations);
  StepEncoder encoder(header);
  StepDecoder decoder(header);
  for (const RecordedStep& step : random_steps(header.nodes, iterations, size_m)) {
    std::string bytes;
    ASSERT_TRUE(encode(encoder, step, bytes));
    std::string_view rest = bytes;
    RecordedStep decoded;
    ASSERT_TRUE(decoder.decode(rest, decoded));
    EXPECT_TRUE(rest.empty());
    expect_same(step, decoded, header.rounding_m);
  }
}

// 17 iterations are more than the predictor looks back; 1e5 m need more than four bytes a coordinate.
INSTANTIATE_TEST_SUITE_P(IterationsAndSizes, StepCodec,
                         testing::Combine(testing::Values(1, 3, 17), testing::Values(0.0, 1e-9, 0.5, 1e5)));

TEST(StepEncoder, GivesWhatContactBetweenMusclesIsAskedAbout) {
  RecordingHeader header = header_for(11, 2);
  header.muscle_contact = true;
  StepEncoder encoder(header);
  StepDecoder decoder(header);
  for (RecordedStep step : random_steps(header.nodes, 2, 0.5)) {
    step.muscle_positions = step.positions;
    step.muscle_positions[3] += Vec3(1e-3, -2e-3, 0);
    std::string bytes;
    ASSERT_TRUE(encode(encoder, step, bytes));
    RecordedStep decoded;
    std::string_view cut = std::string_view(bytes).substr(0, bytes.size() - 1);
    EXPECT_FALSE(StepDecoder(decoder).decode(cut, decoded));
    std::string_view rest = bytes;
    ASSERT_TRUE(decoder.decode(rest, decoded));
    EXPECT_TRUE(rest.empty());
    expect_same(step, decoded, header.rounding_m);
    ASSERT_EQ(decoded.muscle_positions.size(), step.muscle_positions.size());
    for (std::size_t i = 0; i < step.muscle_positions.size(); ++i) {
      EXPECT_EQ(decoded.muscle_positions[i], rounded(step.muscle_positions[i], header.rounding_m));
    }
  }
}

TEST(StepEncoder, EvenMotionCostsNothingButItsPoses) {
  const RecordingHeader header = header_for(1000, 1);
  StepEncoder encoder(header);
  const Vec3 velocity(3 * header.rounding_m, -700 * header.rounding_m, 90000 * header.rounding_m);
  std::mt19937 random(1);
  RecordedStep step = random_step(random, header.nodes, 0.1);
  for (int i = 0; i < 6; ++i) {
    std::string bytes;
    for (std::size_t node = 0; node < step.positions.size(); ++node) {
      step.positions[node] = rounded(step.substep_start[node], header.rounding_m) + velocity;
    }
    ASSERT_TRUE(encode(encoder, step, bytes));
    step.substep_start = step.positions;
    if (i >= 2) {
      EXPECT_EQ(bytes.size(), 2 * 2 * 96 + 3);
    }
  }
}

TEST(StepEncoder, RefusesWhatCannotBeRounded) {
  const RecordingHeader header = header_for(4, 1);
  std::mt19937 random(1);
  const RecordedStep good = random_step(random, header.nodes, 0.1);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e300, -1e12}) {
    for (const bool at_start : {true, false}) {
      RecordedStep step = good;
      (at_start ? step.substep_start : step.positions)[2].y() = bad;
      StepEncoder encoder(header);
      std::string bytes = "as before";
      EXPECT_FALSE(encode(encoder, step, bytes));
      EXPECT_EQ(bytes, "as before");
    }
  }
}

TEST(StepDecoder, RefusesBytesOfNoEncoder) {
  const RecordingHeader header = header_for(4, 1);
  std::mt19937 random(1);
  std::string bytes;
  StepEncoder encoder(header);
  ASSERT_TRUE(encode(encoder, random_step(random, header.nodes, 0.1), bytes));
  RecordedStep step;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    std::string_view cut(bytes.data(), size);
    EXPECT_FALSE(StepDecoder(header).decode(cut, step)) << size;
  }
  bytes[2 * 2 * 96] = 9;  // bytes a coordinate
  std::string_view wrong = bytes;
  EXPECT_FALSE(StepDecoder(header).decode(wrong, step));
}

TEST(RoundingStep, IsAPowerOfTwoThatScalesWithTheScene) {
  for (const double diagonal_m : {1e-6, 0.3, 0.5, 0.7, 1.0, 12345.0}) {
    const double step_m = rounding_step_m(diagonal_m);
    int exponent = 0;
    EXPECT_EQ(std::frexp(step_m, &exponent), 0.5);
    EXPECT_LE(step_m, std::ldexp(diagonal_m, -32));
    EXPECT_GT(step_m, std::ldexp(diagonal_m, -33));
  }
}

/// Displacements that grow evenly are predicted to the bit.
TEST(StepPredictor, TheHighestOrderGoesOnLinearly) {
  StepPredictor predictor(1, 1);
  StepPredictor::Coordinates from(1, 0);
  StepPredictor::Coordinates predicted;
  for (std::uint64_t step = 1; step < 6; ++step) {
    const StepPredictor::Coordinates to(1, from[0] + 10 + 3 * step);
    predictor.predict(from, StepPredictor::orders - 1, predicted);
    if (step > 2) {
      EXPECT_EQ(predicted, to);
    }
    predictor.advance(from, to);
    from = to;
  }
}

}  // namespace
}  // namespace musclebench

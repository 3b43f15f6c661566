#include "core/measure/fibre_record.hpp"

#include <cmath>
#include <sstream>

#include <gtest/gtest.h>

namespace musclebench {
namespace {
/// Two fibres, which grow by 10 and 20 mm a radian from 100 mm, of one muscle; a rigid one of another.
std::vector<FibreFrame> frames() {
  std::vector<FibreFrame> frames;
  for (int i = 0; i <= 5; ++i) {
    const double angle = 0.1 * i;
    frames.push_back({i, angle, {{{0.1 + 0.02 * angle, 0.1 + 0.01 * angle}, 0.25}, {{0.3}, {}}}});
  }
  return frames;
}

const std::vector<std::string> muscle_names = {"a", "b"};

TEST(FibreTables, HaveARowAFrameAndMuscleAndOneAFibre) {
  const FibreTables tables = fibre_tables(muscle_names, frames());
  ASSERT_EQ(tables.muscles.size(), 12U);
  ASSERT_EQ(tables.fibres.size(), 18U);
  const FibreRow& row = tables.muscles[4];
  EXPECT_EQ(row.frame, 2);
  EXPECT_EQ(row.muscle, "a");
  EXPECT_EQ(row.lengths_m, (std::vector<double>{0.1 + 0.01 * 0.2, 0.1 + 0.02 * 0.2}));
  EXPECT_NEAR(row.arms_m.front(), 0.01, 1e-12);
  EXPECT_NEAR(row.arms_m.back(), 0.02, 1e-12);
  EXPECT_NEAR(row.of_mean->arm_m, 0.015, 1e-12);
  EXPECT_NEAR(row.max_stretch, 1.04, 1e-12);
  EXPECT_NEAR(tables.muscles[5].of_mean->arm_m, 0, 1e-12);
  EXPECT_NEAR(tables.fibres[6].arm->arm_m, 0.02, 1e-12);
  EXPECT_EQ(tables.fibres[7].fibre, 2);
}

TEST(FibreTables, LeaveUnknownCellsEmpty) {
  std::vector<FibreFrame> two = frames();
  two.resize(2);
  const FibreTables tables = fibre_tables(muscle_names, two);
  std::ostringstream text;
  write_table(text, fibre_columns(), std::span<const FibreRow>(tables.muscles));
  EXPECT_EQ(text.str().substr(text.str().find('\n') + 1),
            "0,0,a,2,0.1,0.1,0.1,,,,,,,0.25,1\n"
            "0,0,b,1,0.3,0.3,0.3,,,,,,,,1\n"
            "1,5.729577951308233,a,2,0.101,0.1015,0.10200000000000001,,,,,,,0.25,1.02\n"
            "1,5.729577951308233,b,1,0.3,0.3,0.3,,,,,,,,1\n");
}

TEST(SlackNotes, NameMusclesWhoseFibresShorten) {
  std::vector<FibreFrame> some = frames();
  EXPECT_TRUE(slack_notes(muscle_names, some).empty()) << "one grows, the other stays as it is";
  for (FibreFrame& frame : some) frame.muscles[1].lengths_m = {0.3 - 0.01 * frame.angle_rad};
  const std::vector<std::string> notes = slack_notes(muscle_names, some);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_NE(notes[0].find("fibres of b are shorter than at rest in 5 of 5 frames"), std::string::npos) << notes[0];
  EXPECT_TRUE(slack_notes(muscle_names, {}).empty());
}

TEST(FibreTables, OfNoFramesAreEmpty) { EXPECT_TRUE(fibre_tables(muscle_names, {}).muscles.empty()); }

}  // namespace
}  // namespace musclebench

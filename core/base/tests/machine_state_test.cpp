#include "core/base/machine_state.hpp"

#include <chrono>
#include <sched.h>
#include <thread>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

TEST(ContextSwitches, WaitingLeavesTheCpuOfItsOwnAccord) {
  const ContextSwitches before = context_switches();
  for (int i = 0; i < 5; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  ContextSwitches waited = context_switches() - before;
  EXPECT_GE(waited.voluntary, 5);
  EXPECT_GE(waited.involuntary, 0);
  waited += {1, 2};
  EXPECT_GE(waited.voluntary, 6);
}

TEST(MachineLoad, IsPlausibleWhereItIsTold) {
  const MachineLoad load = machine_load();
  EXPECT_GE(load.load_average_1m.value_or(0), 0);
  EXPECT_GT(load.cpu_mhz.value_or(1000), 10);
  EXPECT_FALSE(load.governor.value_or("unknown").empty());
}

TEST(CpuSettings, TellWhetherTheProcessIsPinned) {
  cpu_set_t before;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  EXPECT_EQ(cpu_settings().allowed_cores, CPU_COUNT(&before));
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(sched_getcpu(), &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  EXPECT_EQ(cpu_settings().allowed_cores, 1);
  sched_setaffinity(0, sizeof before, &before);
}

}  // namespace
}  // namespace musclebench

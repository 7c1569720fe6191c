// SPDX-License-Identifier: BSD-3-Clause
#include "apps/mission/stop_condition.h"

#include <csignal>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

TEST(StopCondition, EndsAtItsDuration) {
  StopOptions options;
  options.duration_s = 10;
  const StopCondition stop_condition(options);
  EXPECT_FALSE(stop_condition.reached(time_at(9.99), 1000));
  EXPECT_TRUE(stop_condition.reached(time_at(10), 0));
  EXPECT_EQ(stop_condition.end_reason(time_at(10), 0), "duration");
}

TEST(StopCondition, EndsAtItsKeyframes) {
  StopOptions options;
  options.keyframes = 5;
  const StopCondition stop_condition(options);
  EXPECT_FALSE(stop_condition.reached(time_at(1), 4));
  EXPECT_TRUE(stop_condition.reached(time_at(1), 5));
  EXPECT_EQ(stop_condition.end_reason(time_at(1), 5), "keyframes");
}

TEST(StopCondition, EndsWhenWhoDrivesHasTouchedSomething) {
  StopCondition stop_condition{StopOptions()};
  EXPECT_FALSE(stop_condition.reached(time_at(1), 0));
  stop_condition.collide("touched something");
  EXPECT_TRUE(stop_condition.reached(time_at(1), 0));
  EXPECT_EQ(stop_condition.touched(), "touched something");
}

TEST(StopCondition, EndsWhenTheUserAsks) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const StopCondition stop_condition{StopOptions()};
    EXPECT_FALSE(stop_condition.reached(time_at(1), 0));
    std::raise(signal);
    EXPECT_TRUE(stop_condition.interrupted());
    EXPECT_FALSE(stop_condition.hurried());
    EXPECT_TRUE(stop_condition.reached(time_at(1), 0));
  }
}

TEST(StopCondition, HurriesWhenTheUserAsksAgain) {
  const StopCondition stop_condition{StopOptions()};
  std::raise(SIGHUP);
  std::raise(SIGHUP);  // of the terminal and of the shell in it
  EXPECT_FALSE(stop_condition.hurried());
  std::raise(SIGINT);
  EXPECT_TRUE(stop_condition.hurried());
}

TEST(StopCondition, IsNotWaitedForWhenTheUserAsksAThirdTime) {
  EXPECT_EXIT(
      {
        const StopCondition stop_condition{StopOptions()};
        for (int i = 0; i < 3; ++i) {
          std::raise(SIGINT);
        }
      },
      testing::KilledBySignal(SIGINT), "");
}

TEST(StopCondition, LeavesAHangUpToWhoIgnoresIt) {
  std::signal(SIGHUP, SIG_IGN);  // as nohup does
  {
    const StopCondition stop_condition{StopOptions()};
    std::raise(SIGHUP);
    EXPECT_FALSE(stop_condition.interrupted());
  }
  EXPECT_EQ(std::signal(SIGHUP, SIG_DFL), SIG_IGN);
}

TEST(StopCondition, EndsWhenADeviceIsLost) {
  StopCondition stop_condition{StopOptions()};
  EXPECT_EQ(stop_condition.device_fault(), "");
  stop_condition.lose_device(DeviceError("camera front: no picture for 1 s"));
  EXPECT_TRUE(stop_condition.reached(time_at(1), 0));
  EXPECT_EQ(stop_condition.device_fault(), "camera front: no picture for 1 s");
}

TEST(StopCondition, EndsWhenTheOdometryStaysSilent) {
  const std::string fault = "the wheels tell no number";
  StopCondition stop_condition{StopOptions()};
  stop_condition.watch_odometry(time_at(1), fault);
  stop_condition.watch_odometry(time_at(9), fault);
  stop_condition.watch_odometry(time_at(10.5), "");
  stop_condition.watch_odometry(time_at(12), fault);
  stop_condition.watch_odometry(time_at(21), fault);
  EXPECT_FALSE(stop_condition.reached(time_at(21), 0)) << "it has spoken meanwhile";
  stop_condition.watch_odometry(time_at(22), fault);
  EXPECT_TRUE(stop_condition.reached(time_at(22), 0));
  EXPECT_EQ(stop_condition.device_fault(),
            "odometry: the wheels tell no number; nothing else for 10 s");
}

}  // namespace
}  // namespace panoptes

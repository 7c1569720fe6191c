// SPDX-License-Identifier: BSD-3-Clause
#include "apps/mission/until.h"

#include <csignal>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

TEST(Until, EndsAtItsDuration) {
  UntilOptions options;
  options.duration_s = 10;
  const Until until(options);
  EXPECT_FALSE(until.reached(time_at(9.99), 1000));
  EXPECT_TRUE(until.reached(time_at(10), 0));
  EXPECT_EQ(until.end_reason(time_at(10), 0), "duration");
}

TEST(Until, EndsAtItsKeyframes) {
  UntilOptions options;
  options.keyframes = 5;
  const Until until(options);
  EXPECT_FALSE(until.reached(time_at(1), 4));
  EXPECT_TRUE(until.reached(time_at(1), 5));
  EXPECT_EQ(until.end_reason(time_at(1), 5), "keyframes");
}

TEST(Until, EndsWhenTheUserAsks) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const Until until{UntilOptions()};
    EXPECT_FALSE(until.reached(time_at(1), 0));
    std::raise(signal);
    EXPECT_TRUE(until.interrupted());
    EXPECT_FALSE(until.hurried());
    EXPECT_TRUE(until.reached(time_at(1), 0));
  }
}

TEST(Until, HurriesWhenTheUserAsksAgain) {
  const Until until{UntilOptions()};
  std::raise(SIGHUP);
  std::raise(SIGHUP);  // of the terminal and of the shell in it
  EXPECT_FALSE(until.hurried());
  std::raise(SIGINT);
  EXPECT_TRUE(until.hurried());
}

TEST(Until, IsNotWaitedForWhenTheUserAsksAThirdTime) {
  EXPECT_EXIT(
      {
        const Until until{UntilOptions()};
        for (int i = 0; i < 3; ++i) {
          std::raise(SIGINT);
        }
      },
      testing::KilledBySignal(SIGINT), "");
}

TEST(Until, LeavesAHangUpToWhoIgnoresIt) {
  std::signal(SIGHUP, SIG_IGN);  // as nohup does
  {
    const Until until{UntilOptions()};
    std::raise(SIGHUP);
    EXPECT_FALSE(until.interrupted());
  }
  EXPECT_EQ(std::signal(SIGHUP, SIG_DFL), SIG_IGN);
}

TEST(Until, EndsWhenADeviceIsLost) {
  Until until{UntilOptions()};
  EXPECT_EQ(until.device_fault(), "");
  until.lose_device(DeviceError("camera front: no picture for 1 s"));
  EXPECT_TRUE(until.reached(time_at(1), 0));
  EXPECT_EQ(until.device_fault(), "camera front: no picture for 1 s");
}

}  // namespace
}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/trigger.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace panoptes::sim {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

Rig rig_of(const std::map<std::string, double>& rates_hz) {
  Rig rig;
  for (const auto& [name, rate_hz] : rates_hz) {
    rig.cameras[name].rate_hz = rate_hz;
  }
  return rig;
}

std::vector<FrameSet> sets(const TriggerOptions& options, const Rig& rig, int count,
                           std::uint64_t seed = 1) {
  Trigger trigger(options, rig, Rng(seed));
  std::vector<FrameSet> all;
  for (int i = 0; i < count; ++i) {
    all.push_back(trigger.next());
    trigger.advance();
  }
  return all;
}

std::vector<std::int64_t> stamps_ns(const std::vector<FrameSet>& all, const std::string& camera) {
  std::vector<std::int64_t> stamps;
  for (const FrameSet& set : all) {
    if (const auto found = set.pictures.find(camera); found != set.pictures.end()) {
      stamps.push_back(found->second.stamp.time_since_epoch().count());
    }
  }
  return stamps;
}

TEST(Trigger, ACameraOfNoRateIsInNoSet) {
  for (const FrameSet& set : sets({}, rig_of({{"a", 0}, {"b", 15}}), 5)) {
    EXPECT_THAT(set.pictures, ElementsAre(testing::Key("b")));
  }
  EXPECT_EQ(sets({}, rig_of({{"a", 0}}), 16).back().stamp, time_at(1));
}

TEST(Trigger, OneSignalHasNoSkewAtAll) {
  for (const FrameSet& set : sets({}, rig_of({{"a", 15}, {"b", 15}, {"c", 15}}), 1000)) {
    ASSERT_THAT(set.pictures, SizeIs(3));
    for (const auto& [name, picture] : set.pictures) {
      ASSERT_EQ(picture.stamp, set.stamp);
    }
  }
}

TEST(Trigger, SetsComeAtTheFastestCamerasPulses) {
  const std::vector<FrameSet> all = sets({}, rig_of({{"fast", 25}, {"slow", 10}}), 6);
  EXPECT_THAT(stamps_ns(all, "fast"),
              ElementsAre(0, 40'000'000, 80'000'000, 120'000'000, 160'000'000, 200'000'000));
  // 100 ms lies between the sets at 80 and 120 ms.
  EXPECT_EQ(all[0].pictures.count("slow"), 1U);
  EXPECT_EQ(all[2].pictures.count("slow"), 0U);
  ASSERT_EQ(all[3].pictures.count("slow"), 1U);
  EXPECT_EQ(all[3].pictures.at("slow").stamp, time_at(0.1));
  EXPECT_EQ(all[3].pictures.at("slow").number, 1);
  EXPECT_EQ(all[3].stamp, time_at(0.12));
  EXPECT_EQ(all[5].pictures.at("slow").stamp, time_at(0.2));
}

TEST(Trigger, AnyRateKeepsItsPulsesToTheNanosecond) {
  const std::vector<FrameSet> all = sets({}, rig_of({{"a", 29.97}}), 3000);
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_EQ(all[k].stamp.time_since_epoch().count(),
              std::llround(static_cast<double>(k) * 1e9 / 29.97));
  }
}

TEST(Trigger, OffsetAndPeriodErrorAreRecoveredToTheNanosecond) {
  TriggerOptions options;
  options.groups["usb"] = {{"free"}, 0.012345678, 5e-5, 0, 0};
  const std::vector<FrameSet> all = sets(options, rig_of({{"base", 20}, {"free", 20}}), 2001);
  const std::vector<std::int64_t> base = stamps_ns(all, "base");
  const std::vector<std::int64_t> free = stamps_ns(all, "free");
  EXPECT_EQ(free[0] - base[0], 12'345'678);
  // 2.5 us a picture later, from 12.3 to 17.3 ms behind: none is missed.
  ASSERT_THAT(free, SizeIs(2000));
  for (std::size_t k = 0; k < free.size(); ++k) {
    EXPECT_EQ(free[k] - base[k], 12'345'678 + static_cast<std::int64_t>(k) * 2'500);
  }
}

TEST(Trigger, OfTwoPicturesInOneSetTheLaterIsDelivered) {
  TriggerOptions options;
  options.groups["usb"] = {{"quick"}, 0, -0.1, 0, 0};
  const std::vector<FrameSet> all = sets(options, rig_of({{"base", 20}, {"quick", 20}}), 100);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto last = static_cast<std::int64_t>(k) * 50 / 45;  // in periods of 50 and 45 ms
    EXPECT_EQ(all[k].pictures.at("quick").number, last);
    EXPECT_EQ(all[k].pictures.at("quick").stamp, time_at(0.045 * static_cast<double>(last)));
  }
}

TEST(Trigger, AGroupJittersTogetherWhateverItsRates) {
  TriggerOptions options;
  options.groups["bus"] = {{"a", "b"}, 0, 0, 0.002, 0};
  const std::vector<FrameSet> all = sets(options, rig_of({{"a", 30}, {"b", 15}}), 4000);
  double squares_s2 = 0;
  int common = 0;
  for (std::size_t k = 1; k < all.size(); ++k) {
    const double jitter_s = to_seconds(all[k].stamp) - static_cast<double>(k) / 30;
    squares_s2 += jitter_s * jitter_s;
    EXPECT_LT(std::abs(jitter_s), 0.4 / 30 + 1e-9);
    if (const auto b = all[k].pictures.find("b"); b != all[k].pictures.end()) {
      EXPECT_EQ(b->second.stamp, all[k].pictures.at("a").stamp);
      ++common;
    }
  }
  EXPECT_EQ(common, 1999);
  const double n = static_cast<double>(all.size());
  EXPECT_NEAR(squares_s2 / n, 4e-6, 3 * 4e-6 * std::sqrt(2 / n));
}

TEST(Trigger, LostPicturesAreMissingByNameAndCounted) {
  TriggerOptions options;
  options.groups["all"] = {{"a", "b"}, 0, 0, 0, 0.1};
  const std::vector<FrameSet> all = sets(options, rig_of({{"a", 15}, {"b", 15}}), 4000);
  int lost_a = 0;
  int lost_both = 0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_EQ(all[k].stamp.time_since_epoch().count(),
              std::llround(static_cast<double>(k) * 1e9 / 15));
    const auto a = all[k].pictures.find("a");
    lost_a += a == all[k].pictures.end() ? 1 : 0;
    lost_both += all[k].pictures.empty() ? 1 : 0;
    if (a != all[k].pictures.end()) {
      EXPECT_EQ(a->second.number, static_cast<std::int64_t>(k));
    }
  }
  EXPECT_NEAR(lost_a, 400, 3 * std::sqrt(400 * 0.9));
  EXPECT_NEAR(lost_both, 40, 3 * std::sqrt(40)) << "each camera loses its own";
}

TEST(Trigger, AnotherCameraChangesNothingForTheRest) {
  TriggerOptions options;
  options.groups["one"] = {{"a"}, 0.001, 1e-4, 0.001, 0.05};
  options.groups["two"] = {{"b"}, 0.002, 0, 0.003, 0.2};
  Rig rig = rig_of({{"a", 15}, {"b", 15}});
  const auto before = stamps_ns(sets(options, rig, 300), "b");
  rig.cameras["c"].rate_hz = 10;
  options.groups["three"] = {{"c"}, 0, 0, 0.01, 0.5};
  EXPECT_EQ(stamps_ns(sets(options, rig, 300), "b"), before);
  EXPECT_EQ(stamps_ns(sets(options, rig, 300), "b"), stamps_ns(sets(options, rig, 300), "b"));
  EXPECT_NE(stamps_ns(sets(options, rig, 300, 2), "b"), before);
}

TEST(Trigger, ARigWithoutCamerasHasSetsWithoutPictures) {
  const std::vector<FrameSet> all = sets({}, {}, 3);
  EXPECT_EQ(all[2].stamp.time_since_epoch().count(), 133'333'333);
  EXPECT_THAT(all[2].pictures, IsEmpty());
}

TEST(TriggerOptions, AreReadAndRefused) {
  const auto read = [](const char* text) {
    return read_settings_text<TriggerOptions>(text, "t.yaml");
  };
  const TriggerOptions options = read(
      "latency_s: 0.04\n"
      "groups:\n"
      "  loop: {cameras: [front, back], jitter_s: 0.0001}\n"
      "  usb: {cameras: [floor], offset_s: 0.01, period_error: 2e-5, drops: 0.01}\n");
  EXPECT_EQ(options.latency_s, 0.04);
  EXPECT_THAT(options.groups.at("loop").cameras, ElementsAre("front", "back"));
  EXPECT_EQ(options.groups.at("usb").drops, 0.01);
  const Rig rig = rig_of({{"front", 15}, {"back", 15}, {"floor", 15}});
  EXPECT_TRUE(trigger_faults(options, rig).empty());
  const auto faults_of = [&read](const char* text, const Rig& of) {
    std::vector<std::string> lines;
    for (const KeyFault& fault : trigger_faults(read(text), of)) {
      lines.push_back(fault.key + ": " + fault.what);
    }
    return lines;
  };
  EXPECT_THAT(faults_of("groups: {a: {cameras: [back, flor]}, b: {cameras: [back]}}\n", rig),
              ElementsAre("groups.a.cameras: the rig has no camera flor; did you mean floor?",
                          "groups.b.cameras: back is in the group a already; a camera has one "
                          "clock"));
  try {
    read("groups: {a: {jitter_s: -1, drops: 2}, b: {cameras: []}}\n");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.lines(),
                ElementsAre("t.yaml:1:13: groups.a.cameras: missing; it must be given",
                            "t.yaml:1:24: groups.a.jitter_s: must be from 0 to 1, got -1",
                            "t.yaml:1:35: groups.a.drops: must be from 0 to 1, got 2",
                            "t.yaml:1:52: groups.b.cameras: must name at least one camera"));
  }
}

}  // namespace
}  // namespace panoptes::sim

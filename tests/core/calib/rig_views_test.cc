// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/rig_views.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/driven_rose.h"

namespace panoptes {
namespace {

/// Pictures of two cameras whose clocks tick apart from each other.
std::vector<TakenPicture> taken_apart(const DrivenRose& drive) {
  std::vector<TakenPicture> taken;
  constexpr Duration kMargin = std::chrono::milliseconds(50);
  for (std::size_t camera = 0; camera < 2; ++camera) {
    std::size_t frame = 0;
    for (Time at = drive.instant(0) + kMargin + camera * std::chrono::milliseconds(23);
         at < drive.path().end() - kMargin; at += std::chrono::milliseconds(67)) {
      taken.push_back({at, camera, frame++});
    }
  }
  std::stable_sort(taken.begin(), taken.end(),
                   [](const auto& a, const auto& b) { return a.instant < b.instant; });
  return taken;
}

std::vector<std::set<std::size_t>> cameras_by_instant(const ChosenViews& chosen) {
  std::vector<std::set<std::size_t>> cameras(chosen.instants.size());
  for (const ChosenViews::View& view : chosen.views) {
    EXPECT_TRUE(cameras[view.instant].insert(view.camera).second) << "one picture of each";
  }
  return cameras;
}

TEST(RigViews, WhileTheBodyStandsPicturesAreOfOneInstantHoweverFarApart) {
  const DrivenRose drive({}, Rng(1));  // it stands for a second first
  const WheelReadings wheels = [&drive](Time at) { return drive.wheels(at); };
  const ChosenViews chosen = choose_views(taken_apart(drive), 2, wheels, kSameInstant);
  const auto cameras = cameras_by_instant(chosen);
  ASSERT_GT(cameras.size(), 20U);
  EXPECT_EQ(cameras.front().size(), 2U);
  for (std::size_t i = 1; i < cameras.size(); ++i) {
    EXPECT_EQ(cameras[i].size(), 1U) << "it moves between the cameras' pictures";
  }
}

TEST(RigViews, WhatIsTakenTogetherIsOfOneInstant) {
  const DrivenRose drive({}, Rng(1));
  const WheelReadings wheels = [&drive](Time at) { return drive.wheels(at); };
  std::vector<TakenPicture> taken = taken_apart(drive);
  std::erase_if(taken, [](const TakenPicture& each) { return each.camera == 1; });
  for (std::size_t i = taken.size(); i-- > 0;) {
    TakenPicture other = taken[i];
    other.camera = 1;
    other.instant += std::chrono::milliseconds(1);
    taken.insert(taken.begin() + static_cast<std::ptrdiff_t>(i) + 1, other);
  }
  const ChosenViews chosen = choose_views(taken, 2, wheels, kSameInstant);
  for (const auto& cameras : cameras_by_instant(chosen)) {
    EXPECT_EQ(cameras.size(), 2U);
  }
}

}  // namespace
}  // namespace panoptes

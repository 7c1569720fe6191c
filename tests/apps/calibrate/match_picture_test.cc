// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/match_picture.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "tests/support/calibrated_rig.h"

namespace panoptes {
namespace {

/// Points that are believed in both views and of one of both cameras' maps, by counting.
std::size_t common_points(const RigCalibration& calibration, std::size_t a, std::size_t b) {
  std::map<std::size_t, std::set<std::size_t>> views_of_point;
  for (const RigSeen& seen : calibration.tracks.seen) {
    if (seen.believed && (seen.view == a || seen.view == b)) {
      views_of_point[seen.point].insert(seen.view);
    }
  }
  return static_cast<std::size_t>(
      std::count_if(views_of_point.begin(), views_of_point.end(),
                    [](const auto& each) { return each.second.size() == 2; }));
}

std::size_t believed(const MatchedViews& views) {
  return static_cast<std::size_t>(
      std::count_if(views.matches.begin(), views.matches.end(),
                    [](const InterMapMatch& match) { return match.believed; }));
}

TEST(MatchPicture, NoOtherTwoViewsHaveMorePointsInCommon) {
  const CalibratedRig rig({});
  const RigTracks& tracks = rig.calibration.tracks;
  const std::optional<MatchedViews> best = best_matched_views(rig.calibration, 0, 1);
  ASSERT_TRUE(best);
  EXPECT_EQ(tracks.views[best->first].camera, 0U);
  EXPECT_EQ(tracks.views[best->second].camera, 1U);
  EXPECT_EQ(believed(*best), common_points(rig.calibration, best->first, best->second));
  for (std::size_t a = 0; a < tracks.views.size(); a += 7) {
    for (std::size_t b = 0; b < tracks.views.size(); b += 5) {
      if (tracks.views[a].camera == 0 && tracks.views[b].camera == 1) {
        EXPECT_LE(common_points(rig.calibration, a, b), believed(*best));
      }
    }
  }
  const std::optional<MatchedViews> other = best_matched_views(rig.calibration, 1, 0);
  ASSERT_TRUE(other);
  EXPECT_EQ(believed(*other), believed(*best)) << "the order tells nothing";
}

TEST(MatchPicture, WhatIsLeftOutIsDrawnButNotCounted) {
  CalibratedRig rig({});
  const std::optional<MatchedViews> before = best_matched_views(rig.calibration, 0, 1);
  ASSERT_TRUE(before);
  for (RigSeen& seen : rig.calibration.tracks.seen) {
    if (seen.px == before->matches.front().second_px) {
      seen.believed = false;
    }
  }
  const std::optional<MatchedViews> after = best_matched_views(rig.calibration, 0, 1);
  ASSERT_TRUE(after);
  EXPECT_LE(believed(*after), believed(*before));
  EXPECT_GE(believed(*after), believed(*before) - 1);
  const cv::Mat picture = draw_matches(rig.calibration, *after, rig.blank(), rig.blank());
  EXPECT_EQ(picture.type(), CV_8UC3);
  EXPECT_GT(picture.cols, 2 * 600);
}

TEST(MatchPicture, CamerasThatShareNothingHaveNone) {
  DrivenScene scene;
  scene.shares = false;
  const CalibratedRig rig(scene);
  EXPECT_FALSE(best_matched_views(rig.calibration, 0, 1));
}

}  // namespace
}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/rig_reprojection_picture.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/calibrated_rig.h"

namespace panoptes {
namespace {

std::set<std::size_t> points_in(const RigTracks& tracks, const std::vector<std::size_t>& views) {
  std::set<std::size_t> points;
  for (const RigSeen& seen : tracks.seen) {
    if (seen.believed && std::find(views.begin(), views.end(), seen.view) != views.end()) {
      points.insert(seen.point);
    }
  }
  return points;
}

TEST(RigReprojectionPicture, ShowsViewsOfTheCameraThatShowManyPoints) {
  const CalibratedRig rig({});
  const RigTracks& tracks = rig.calibration.tracks;
  const std::vector<std::size_t> views = telling_views(rig.calibration, 1, 3);
  ASSERT_EQ(views.size(), 3U);
  EXPECT_TRUE(std::is_sorted(views.begin(), views.end()));
  for (const std::size_t view : views) {
    EXPECT_EQ(tracks.views[view].camera, 1U);
  }
  const std::size_t together = points_in(tracks, views).size();
  for (std::size_t view = 0; view < tracks.views.size(); ++view) {
    if (tracks.views[view].camera == 1) {
      EXPECT_LE(points_in(tracks, {view}).size(), together);
    }
  }
  std::vector<ShownView> shown;
  for (const std::size_t view : views) {
    shown.push_back({view, rig.blank()});
  }
  const cv::Mat picture = draw_rig_reprojection(rig.calibration, rig.calibration.wheels, 1, shown);
  EXPECT_EQ(picture.type(), CV_8UC3);
  EXPECT_GT(picture.rows, 3 * 480);
}

}  // namespace
}  // namespace panoptes

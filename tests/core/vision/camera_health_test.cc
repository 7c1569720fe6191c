// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/camera_health.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace panoptes {
namespace {

constexpr double kFrame_s = 1.0 / 15;
constexpr double kNoise_grey = 3;

Rig one_camera() {
  Rig rig;
  rig.cameras["eye"].roles = {"floor"};
  rig.cameras["eye"].intrinsics = pinhole(320, 240, deg_to_rad(80));
  return rig;
}

// A picture, its noise drawn anew each time.
class Scene {
 public:
  cv::Mat noisy(cv::Mat clear, double sigma_grey = kNoise_grey) {
    cv::Mat noise(clear.size(), CV_16SC3);
    rng_.fill(noise, cv::RNG::NORMAL, cv::Scalar::all(0), cv::Scalar::all(sigma_grey));
    cv::Mat sum;
    cv::add(clear, noise, sum, cv::noArray(), CV_8UC3);
    return sum;
  }
  cv::Mat plain(const cv::Scalar& bgr) { return noisy(cv::Mat(240, 320, CV_8UC3, bgr)); }
  // Boxes of other greys on a floor; `shift_px` moves them.
  cv::Mat things(int shift_px = 0) { return noisy(clear_things(shift_px)); }
  static cv::Mat clear_things(int shift_px) {
    cv::Mat bgr(240, 320, CV_8UC3, cv::Scalar(90, 100, 110));
    for (int i = -3; i < 8; ++i) {
      const cv::Rect box(50 * i + shift_px, 40 + 17 * (i & 3), 25, 60);
      cv::rectangle(bgr, box, cv::Scalar(30, 60 + 15 * i, 170 - 10 * i), cv::FILLED);
    }
    return bgr;
  }
  // No light: what is read is noise about none.
  cv::Mat dark() { return noisy(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(0)), 10); }

 private:
  cv::RNG rng_{3};
};

// A robot that drives straight ahead at 0.3 m/s unless told otherwise, and what its camera says.
struct Watch {
  CameraHealth health{one_camera()};
  Scene scene;
  Pose2 T_odom_body;
  double at_s = 0;

  CameraReport see(const cv::Mat& bgr, const Twist2& twist = {0.3, 0}) {
    Observation seen;
    at_s += kFrame_s;
    T_odom_body = T_odom_body * exp_twist(twist, kFrame_s);
    seen.stamp = time_at(at_s);
    seen.odometry.T_odom_body = T_odom_body;
    if (!bgr.empty()) {
      seen.pictures["eye"] = {seen.stamp, bgr};
    }
    return health.check(seen).at("eye");
  }
  void see_things(int pictures) {
    for (int i = 0; i < pictures; ++i) {
      EXPECT_EQ(see(scene.things()).state, CameraState::kGood);
    }
  }
};

TEST(CameraHealth, SaysWhatIsWrongWithTheFirstPictureOfIt) {
  Watch w;
  w.see_things(5);
  const cv::Mat kept = w.scene.things();
  w.see(kept);
  EXPECT_EQ(w.see(kept).state, CameraState::kFrozen);
  EXPECT_EQ(w.see(kept).frozen, 2);
  EXPECT_EQ(told(w.health.reports()), "camera eye: frozen");
  w.see_things(2);
  EXPECT_EQ(w.see(w.scene.dark()).state, CameraState::kDark);
  w.see_things(2);
  EXPECT_EQ(w.see(w.scene.plain(cv::Scalar::all(255))).state, CameraState::kSaturated);
  w.see_things(2);
  EXPECT_EQ(w.see(w.scene.plain(cv::Scalar(20, 25, 40))).state, CameraState::kCovered);
  EXPECT_EQ(told(w.health.reports()), "camera eye: covered");
}

TEST(CameraHealth, ReportsWhatACameraIsForByItsRoles) {
  Rig rig = one_camera();
  for (const char* role : {"loop_front", "loop_back", "loop_left", "stereo_left"}) {
    rig.cameras[role] = rig.cameras["eye"];
    rig.cameras[role].roles = {role};
  }
  const CameraReports reports = CameraHealth(rig).reports();
  EXPECT_TRUE(reports.at("eye").is_floor);
  EXPECT_FALSE(reports.at("eye").is_loop);
  EXPECT_TRUE(reports.at("loop_front").is_loop);
  EXPECT_TRUE(reports.at("loop_back").is_loop);
  EXPECT_TRUE(reports.at("loop_left").is_loop);
  EXPECT_FALSE(reports.at("stereo_left").is_loop);
}

TEST(CameraHealth, CountsTheTimeThatACameraIsLost) {
  Watch w;
  w.see_things(5);
  for (int i = 0; i < 30; ++i) {
    w.see(w.scene.dark());
  }
  const CameraReport report = w.see(w.scene.things());
  EXPECT_EQ(report.state, CameraState::kGood);
  EXPECT_EQ(report.dark, 30);
  EXPECT_NEAR(to_seconds(report.lost), 2, 1e-6);
}

TEST(CameraHealth, IsLostSinceItsFirstFaultWhateverTheNext) {
  Watch w;
  w.see_things(5);
  const Time first = w.see(w.scene.dark()).since;
  w.see(w.scene.plain(cv::Scalar::all(255)));
  const CameraReport report = w.see(w.scene.dark());
  EXPECT_EQ(report.state, CameraState::kDark);
  EXPECT_EQ(report.since, first);
  EXPECT_GT(w.see(w.scene.things()).since, first);
}

TEST(CameraHealth, ThreePicturesMissingInARowAreALostCamera) {
  Watch w;
  w.see_things(3);
  EXPECT_EQ(w.see({}).state, CameraState::kGood);
  EXPECT_EQ(w.see({}).state, CameraState::kGood);
  EXPECT_EQ(w.see({}).state, CameraState::kMissing);
  EXPECT_EQ(w.see(w.scene.things()).state, CameraState::kGood);
  EXPECT_EQ(w.see(w.scene.things()).missing, 3);
  w.see({});
  EXPECT_EQ(w.see(w.scene.things()).missing, 4);
}

// Each picture comes after a deadline that passed without it.
TEST(CameraHealth, PicturesBehindADeadlineAreNotMissing) {
  Watch w;
  const auto look = [&w](double seen_s, double taken_s) {
    Observation seen;
    seen.stamp = time_at(seen_s);
    seen.odometry.T_odom_body = w.T_odom_body = w.T_odom_body * exp_twist({0.3, 0}, kFrame_s);
    if (taken_s >= 0) {
      seen.pictures["eye"] = {time_at(taken_s), w.scene.things()};
    }
    return w.health.check(seen).at("eye");
  };
  look(0, 0);
  for (int i = 1; i <= 30; ++i) {
    look((i + 0.8) * kFrame_s, -1);
    if (i % 5 != 0) {
      look((i + 0.4) * kFrame_s, i * kFrame_s);
    }
  }
  const CameraReport report = look(31.4 * kFrame_s, 31 * kFrame_s);
  EXPECT_EQ(report.missing, 6);  // of i = 5, 10 to 30
  EXPECT_EQ(report.state, CameraState::kGood);
}

TEST(CameraHealth, PicturesAsOldAsThatAreLate) {
  Watch w;
  w.see_things(3);
  Observation seen;
  seen.stamp = time_at(w.at_s + 10 * kFrame_s);
  seen.pictures["eye"] = {time_at(w.at_s + kFrame_s), w.scene.things()};
  EXPECT_EQ(w.health.check(seen).at("eye").state, CameraState::kLate);
  EXPECT_EQ(w.health.reports().at("eye").late, 1);
  EXPECT_TRUE(w.health.accepted(seen).pictures.empty());
}

// A bus that lags does so by less at times; another clock never.
TEST(CameraHealth, PicturesAllOldFromTheStartAreOfAnotherClock) {
  for (const bool of_another_clock : {true, false}) {
    Watch w;
    for (int i = 0; i < 60; ++i) {
      const double now_s = 1 + i * kFrame_s;
      const double age_s = of_another_clock || i % 20 != 19 ? 0.5 : 0.1;
      Observation seen;
      seen.stamp = time_at(now_s);
      seen.pictures["eye"] = {time_at(now_s - age_s), w.scene.things(i)};
      w.health.check(seen);
    }
    if (of_another_clock) {
      EXPECT_THAT(w.health.wrong_clock(), ::testing::HasSubstr("stamps of eye look 0.50 s early"));
    } else {
      EXPECT_EQ(w.health.wrong_clock(), "");
    }
  }
}

TEST(CameraHealth, EqualPicturesOfARobotThatStandsAreNoFault) {
  Watch w;
  const cv::Mat kept = Scene::clear_things(0);  // without noise
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(w.see(kept, {0, 0}).state, CameraState::kGood);
  }
  w.see(kept);
  EXPECT_EQ(w.see(kept).state, CameraState::kFrozen);
}

TEST(CameraHealth, APlainWallThatIsDrivenUpToIsNoFault) {
  Watch w;
  // Its foot slides down and out of the picture, below it is floor.
  for (int foot = 100; foot < 260; foot += 4) {
    cv::Mat bgr(240, 320, CV_8UC3, cv::Scalar(180, 185, 190));
    if (foot < 240) {
      bgr.rowRange(foot, 240).setTo(cv::Scalar(90, 100, 110));
    }
    EXPECT_EQ(w.see(w.scene.noisy(bgr), {0.2, 0}).state, CameraState::kGood) << foot;
  }
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(w.see(w.scene.plain(cv::Scalar(180, 185, 190)), {0, 0}).state, CameraState::kGood);
  }
}

TEST(CameraHealth, ThingsThatLeaveThePictureSidewaysAreNoFault) {
  Watch w;
  const double turn_radps = 1.0;
  const double step_px = 320 / (2 * std::tan(deg_to_rad(40))) * turn_radps * kFrame_s;
  for (int i = 0; i < 60; ++i) {
    cv::Mat bgr(240, 320, CV_8UC3, cv::Scalar(180, 185, 190));
    const int left = 40 + static_cast<int>(step_px * i);
    cv::rectangle(bgr, cv::Rect(left, 60, 90, 120), cv::Scalar(40, 60, 90), cv::FILLED);
    EXPECT_EQ(w.see(w.scene.noisy(bgr), {0, turn_radps}).state, CameraState::kGood) << i;
  }
}

TEST(CameraHealth, AHandThatComesOverTheLensIsSeenWhenNothingElseIs) {
  Watch w;
  w.see_things(5);
  CameraState last = CameraState::kGood;
  for (int from = 320; from >= -64; from -= 64) {
    cv::Mat bgr = Scene::clear_things(0);
    bgr.colRange(std::max(0, from), 320).setTo(cv::Scalar(20, 25, 40));
    last = w.see(w.scene.noisy(bgr), {0, 0}).state;
  }
  EXPECT_EQ(last, CameraState::kCovered);
  // It is believed again once it has shown something for a tenth of a second.
  EXPECT_EQ(w.see(w.scene.things()).state, CameraState::kCovered);
  EXPECT_EQ(w.see(w.scene.things()).state, CameraState::kCovered);
  EXPECT_EQ(w.see(w.scene.things()).state, CameraState::kGood);
}

TEST(CameraHealth, NoWallIsAllAround) {
  Watch w;
  CameraState state = CameraState::kGood;
  double turned_rad = 0;
  while (state == CameraState::kGood && turned_rad < 7) {
    state = w.see(w.scene.plain(cv::Scalar(60, 70, 90)), {0, 1}).state;
    turned_rad += kFrame_s;
  }
  EXPECT_EQ(state, CameraState::kCovered);
  EXPECT_GT(turned_rad, 3);
}

}  // namespace
}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/camera_sensor.h"

#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "tests/sim/sensors/sphere.h"

namespace panoptes::sim {
namespace {

using testing::ElementsAre;

const Intrinsics kLens = pinhole(160, 120, deg_to_rad(80));

SensorOptions clean() {
  SensorOptions options;
  options.white_ms = 4;
  options.exposure = FixedExposure{4, 1};
  options.vignetting = 0;
  options.noise = NoNoise{};
  return options;
}

// Black to the left of straight ahead, white to the right, edges a pixel wide so that nothing
// flickers.
Vec3 edge(const Vec3& d_scene) {
  const double ahead_px = kLens.fx_px * d_scene.x() / d_scene.z();
  return Vec3::Constant(std::clamp(ahead_px + 0.5, 0.0, 1.0) * 0.9);
}

Vec3 stripes(const Vec3& d_scene) {
  return Vec3(0.4 + 0.3 * std::sin(25 * d_scene.x()), 0.4 + 0.3 * std::sin(20 * d_scene.y()),
              0.4 + 0.3 * std::sin(30 * (d_scene.x() + d_scene.y())));
}

CameraSensor::Draw drawing(const Light& light, int* drawings = nullptr) {
  return [light, drawings](const View& view, const RenderOutputs& outputs) {
    if (drawings != nullptr && view.intrinsics.width_px == kLens.width_px) {
      ++*drawings;
    }
    return draw_sphere(light, view, outputs);
  };
}

Pose3 still(Duration) { return {}; }

// Turns to the right.
std::function<Pose3(Duration)> turning(double radps) {
  return [radps](Duration after) {
    return Pose3{Eigen::Quaterniond(Eigen::AngleAxisd(radps * to_seconds(after), Vec3::UnitY())),
                 Vec3::Zero()};
  };
}

double light_at(const cv::Mat& bgr, int v, int u) {
  return std::pow(bgr.at<cv::Vec3b>(v, u)[1] / 255.0, 2);
}

// The column where the light of a row passes half of the edge's.
double edge_px(const cv::Mat& bgr, int v) {
  double left = 0;
  for (int u = 0; u < bgr.cols; ++u) {
    left += 1 - light_at(bgr, v, u) / 0.9;
  }
  return left;  // the width of what is black
}

TEST(CameraSensor, StandingStillItDrawsOnce) {
  int drawings = 0;
  CameraSensor camera("a", kLens, clean(), Rng(1));
  const SensorImage image = camera.take(drawing(stripes, &drawings), still, 0, {});
  EXPECT_EQ(drawings, 1);
  EXPECT_EQ(cv::norm(image.bgr, draw_sphere(stripes, {kLens, {}}, {}).bgr, cv::NORM_INF), 0);
  EXPECT_TRUE(image.floor_label.empty());
}

TEST(CameraSensor, SlowMotionIsDrawnOnceToo) {
  int drawings = 0;
  CameraSensor camera("a", kLens, clean(), Rng(1));
  camera.take(drawing(stripes, &drawings), turning(0.5), 0, {});  // 0.2 px in 4 ms
  EXPECT_EQ(drawings, 1);
}

TEST(CameraSensor, BlurIsTheMeanOverTheExposure) {
  SensorOptions options = clean();
  options.exposure = FixedExposure{10, 0.4};
  constexpr double kTurn_radps = 9;
  int drawings = 0;
  CameraSensor camera("a", kLens, options, Rng(1));
  const cv::Mat bgr = camera.take(drawing(stripes, &drawings), turning(kTurn_radps), 0, {}).bgr;
  // 9 rad/s for 10 ms are 8.6 px in the middle and 14.6 at the sides of 95 px of focal length.
  EXPECT_GE(drawings, 14);
  EXPECT_LE(drawings, 19);
  cv::Mat sum(kLens.height_px, kLens.width_px, CV_64FC3, cv::Scalar::all(0));
  constexpr int kMany = 200;
  for (int i = 0; i < kMany; ++i) {
    const Pose3 T = turning(kTurn_radps)(from_seconds(0.01 * ((i + 0.5) / kMany - 0.5)));
    cv::Mat one;
    draw_sphere(stripes, {kLens, T}, {}).bgr.convertTo(one, CV_64F, 1 / 255.0);
    sum += one.mul(one);
  }
  cv::Mat mean;
  cv::sqrt(sum / kMany, mean);
  cv::Mat image;
  bgr.convertTo(image, CV_64F);
  constexpr double kGreyLevels = 1.5;  // roundings of the drawings and of the mean
  EXPECT_LT(cv::norm(image, mean * 255, cv::NORM_INF), kGreyLevels);
}

TEST(CameraSensor, BlurIsAsLongAsTheExposure) {
  SensorOptions options = clean();
  options.exposure = FixedExposure{10, 0.4};
  for (const double radps : {4.0, 8.0}) {
    CameraSensor camera("a", kLens, options, Rng(1));
    const cv::Mat bgr = camera.take(drawing(edge), turning(radps), 0, {}).bgr;
    int grey_columns = 0;
    for (int u = 0; u < kLens.width_px; ++u) {
      const double share = light_at(bgr, 60, u) / 0.9;
      grey_columns += share > 0.02 && share < 0.98;
    }
    const double expected_px = kLens.fx_px * radps * 0.01;
    EXPECT_NEAR(grey_columns, expected_px, 2);  // a pixel of the edge at each end
    EXPECT_NEAR(edge_px(bgr, 60), 80, 0.3);     // about where it stood in the middle
  }
}

TEST(CameraSensor, WithoutBlurOneInstantIsShown) {
  SensorOptions options = clean();
  options.exposure = FixedExposure{10, 0.4};
  options.motion_blur = false;
  CameraSensor camera("a", kLens, options, Rng(1));
  const cv::Mat bgr = camera.take(drawing(stripes), turning(9), 0, {}).bgr;
  EXPECT_EQ(cv::norm(bgr, draw_sphere(stripes, {kLens, {}}, {}).bgr, cv::NORM_INF), 0);
}

TEST(CameraSensor, MotionTowardsNearThingsBlursToo) {
  SensorOptions options = clean();
  options.exposure = FixedExposure{20, 0.2};
  int drawings = 0;
  CameraSensor camera("a", kLens, options, Rng(1));
  const auto aside = [](Duration after) {
    return Pose3{Eigen::Quaterniond::Identity(), Vec3(3 * to_seconds(after), 0, 0)};
  };
  camera.take(drawing(stripes, &drawings), aside, 0, {});
  // 6 cm before a wall at 3 m: 1.9 px in the middle, more nowhere near twice of it.
  EXPECT_EQ(drawings, 3);
}

// A sphere that turns to the left before a camera that stands, seen in objects 0 to 3, and
// something behind the camera that moves too.
std::function<Instant(Duration)> turning_world(double radps) {
  return [radps](Duration after) {
    Instant now;
    for (std::size_t object = 0; object < 4; ++object) {
      now.scene_state.T_scene_object[object] = turning(radps)(after).inverse();
    }
    now.scene_state.T_scene_object[4].translation.x() = to_seconds(after);
    return now;
  };
}

CameraSensor::DrawScene drawing_objects(const Light& light) {
  return [light](View view, const RenderOutputs& outputs, const SceneState& scene_state) {
    view.T_scene_camera = scene_state.T_scene_object.at(0).inverse() * view.T_scene_camera;
    return draw_sphere(light, view, outputs);
  };
}

TEST(CameraSensor, WhatMovesBeforeItBlursAsUnderItsOwnMotion) {
  SensorOptions options = clean();
  options.exposure = FixedExposure{10, 0.4};
  options.row_us = 50;
  const RenderOutputs outputs{.floor_label = true, .depth = true, .instance = true};
  CameraSensor turns("a", kLens, options, Rng(1));
  const SensorImage seen = turns.take(drawing(stripes), turning(5), 0, outputs);
  CameraSensor stands("a", kLens, options, Rng(1));
  const SensorImage same = stands.take(drawing_objects(stripes), turning_world(5), 0, outputs);
  EXPECT_EQ(cv::norm(same.bgr, seen.bgr, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(same.depth_m, seen.depth_m, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(same.instance, seen.instance, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(same.bgr, draw_sphere(stripes, {kLens, {}}, {}).bgr, cv::NORM_INF), 10);
}

TEST(CameraSensor, WhatMovesUnseenCostsNoDrawing) {
  SensorOptions options = clean();
  options.exposure = FixedExposure{10, 0.4};
  CameraSensor camera("a", kLens, options, Rng(1));
  int drawings = 0;
  const auto still_sphere = [&](const View& view, const RenderOutputs& outputs, const SceneState&) {
    return drawing(stripes, &drawings)(view, outputs);
  };
  const auto behind = [](Duration after) {
    Instant now;
    now.scene_state.T_scene_object[4].translation.x() = 9 * to_seconds(after);
    return now;
  };
  camera.take(still_sphere, behind, 0, {});
  EXPECT_EQ(drawings, 1);
}

TEST(CameraSensor, RollingRowsLean) {
  SensorOptions options = clean();
  options.row_us = 100;
  options.exposure = FixedExposure{0.1, 40};
  constexpr double kTurn_radps = 10;
  CameraSensor camera("a", kLens, options, Rng(1));
  const cv::Mat bgr = camera.take(drawing(edge), turning(kTurn_radps), 0, {}).bgr;
  // Turning right, the edge moves left; later rows, the lower ones, see it farther left.
  constexpr double kStep_px = 0.6;  // rows are drawn together as long as it moves half a pixel
  for (const int v : {0, 30, 60, 90, 119}) {
    const double angle = kTurn_radps * (v - 59.5) * 100e-6;
    EXPECT_NEAR(edge_px(bgr, v), 80 - kLens.fx_px * std::tan(angle), kStep_px) << v;
  }
}

TEST(CameraSensor, TheTruthLeansWithTheRows) {
  SensorOptions options = clean();
  options.row_us = 100;
  options.exposure = FixedExposure{5, 0.8};
  CameraSensor camera("a", kLens, options, Rng(1));
  const RenderOutputs outputs{.floor_label = true, .depth = true, .instance = true};
  const SensorImage image = camera.take(drawing(edge), turning(10), 0, outputs);
  ASSERT_EQ(image.instance.size(), image.bgr.size());
  ASSERT_EQ(image.depth_m.size(), image.bgr.size());
  ASSERT_EQ(image.floor_label.size(), image.bgr.size());
  for (const int v : {0, 30, 90, 119}) {
    int left = 0;  // where x < 0
    for (int u = 0; u < kLens.width_px; ++u) {
      left += (image.instance.at<std::uint16_t>(v, u) - 1) % 2;
    }
    EXPECT_NEAR(left, edge_px(image.bgr, v), 1) << v;
  }
}

TEST(CameraSensor, AMosaicKeepsColours) {
  SensorOptions options = clean();
  options.bayer = true;
  CameraSensor camera("a", kLens, options, Rng(1));
  const Light blue = [](const Vec3&) { return Vec3(0.8, 0.3, 0.1); };
  const cv::Mat bgr = camera.take(drawing(blue), still, 0, {}).bgr;
  const cv::Mat expected = draw_sphere(blue, {kLens, {}}, {}).bgr;
  EXPECT_EQ(cv::norm(bgr, expected, cv::NORM_INF), 0);
  // What is fine comes out different from a sensor with all colours in each pixel, smooth things
  // nearly the same.
  const cv::Mat smooth = camera.take(drawing(stripes), still, 1, {}).bgr;
  EXPECT_LT(cv::norm(smooth, draw_sphere(stripes, {kLens, {}}, {}).bgr, cv::NORM_L1),
            2.0 * 3 * static_cast<double>(smooth.total()));
  const cv::Mat sharp = camera.take(drawing(edge), still, 2, {}).bgr;
  EXPECT_GT(cv::norm(sharp, draw_sphere(edge, {kLens, {}}, {}).bgr, cv::NORM_INF), 10);
}

Light even(double light) {
  return [light](const Vec3&) { return Vec3::Constant(light); };
}

TEST(CameraSensor, LongerExposureAndGainAreMoreLight) {
  for (const auto& [ms, gain] : {std::pair{4.0, 1.0}, {8.0, 1.0}, {4.0, 2.0}, {1.0, 1.0}}) {
    SensorOptions options = clean();
    options.exposure = FixedExposure{ms, gain};
    CameraSensor camera("a", kLens, options, Rng(1));
    const cv::Mat bgr = camera.take(drawing(even(0.2)), still, 0, {}).bgr;
    EXPECT_NEAR(light_at(bgr, 60, 80), 0.2 * ms / 4 * gain, 0.003);
  }
}

TEST(CameraSensor, AutoExposureIsSettledFromTheFirstPicture) {
  for (const double light : {0.02, 0.2, 3.0}) {
    SensorOptions options;
    options.exposure = AutoExposure{};
    CameraSensor camera("a", kLens, options, Rng(1));
    const cv::Mat bgr = camera.take(drawing(even(light)), still, 0, {}).bgr;
    EXPECT_NEAR(cv::mean(bgr)[0], 110, 3) << light;
  }
}

TEST(CameraSensor, AutoExposureFollowsTheLightWithItsTimeConstant) {
  SensorOptions options = clean();
  options.exposure = AutoExposure{.most_ms = 100, .time_constant_pictures = 5};
  CameraSensor camera("a", kLens, options, Rng(1));
  camera.take(drawing(even(0.4)), still, 0, {});
  const double before_ms = camera.exposure_ms();
  for (int i = 1; i <= 5; ++i) {
    camera.take(drawing(even(0.1)), still, i, {});
  }
  // After one time constant 1 - 1/e of the way (in logarithms) to four times the light is done.
  const double done = std::log(camera.exposure_ms() / before_ms) / std::log(4.0);
  EXPECT_NEAR(done, 1 - std::exp(-1.0), 0.02);
  for (int i = 6; i <= 40; ++i) {
    camera.take(drawing(even(0.1)), still, i, {});
  }
  EXPECT_NEAR(camera.exposure_ms() / before_ms, 4, 0.1);
  EXPECT_EQ(camera.gain(), 1);
}

TEST(CameraSensor, AutoExposureCountsPicturesThatWereNotTaken) {
  const auto after = [](const std::vector<std::int64_t>& pictures) {
    SensorOptions options = clean();
    options.exposure = AutoExposure{};
    CameraSensor camera("a", kLens, options, Rng(1));
    for (const std::int64_t picture : pictures) {
      camera.take(drawing(even(picture == 0 ? 0.4 : 0.1)), still, picture, {});
    }
    return camera.exposure_ms() * camera.gain();
  };
  EXPECT_NEAR(after({0, 1, 2, 3}) / after({0, 3}), 1, 0.02);
}

TEST(CameraSensor, AutoExposureStopsAtItsLimits) {
  SensorOptions options;
  options.exposure = AutoExposure{};
  CameraSensor dark("a", kLens, options, Rng(1));
  dark.take(drawing(even(1e-5)), still, 0, {});
  EXPECT_EQ(dark.exposure_ms(), AutoExposure{}.most_ms);
  EXPECT_EQ(dark.gain(), AutoExposure{}.most_gain);
  CameraSensor bright("a", kLens, options, Rng(1));
  bright.take(drawing(even(1e4)), still, 0, {});
  EXPECT_EQ(bright.exposure_ms(), AutoExposure{}.least_ms);
  EXPECT_EQ(bright.gain(), 1);
}

TEST(CameraSensor, NoiseIsDecidedBySeedCameraAndPictureAlone) {
  const auto image = [](std::uint64_t seed, const std::string& name, std::int64_t picture,
                        bool one_before = false) {
    SensorOptions options;
    options.exposure = FixedExposure{};
    CameraSensor camera(name, kLens, options, Rng(seed));
    if (one_before) {
      camera.take(drawing(stripes), still, picture - 1, {});
    }
    return camera.take(drawing(stripes), still, picture, {}).bgr;
  };
  EXPECT_EQ(cv::norm(image(1, "a", 5), image(1, "a", 5, true), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(image(1, "a", 5), image(1, "a", 6), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(image(1, "a", 5), image(1, "b", 5), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(image(1, "a", 5), image(2, "a", 5), cv::NORM_INF), 0);
}

TEST(CameraSensor, SettingsReadBackTheSame) {
  const auto options = read_settings_text<SensorOptions>(
      "exposure: {kind: auto, target_grey: 90}\nnoise: none\nvignetting: 0.1\nrow_us: 20\n"
      "bayer: true\nmotion_blur: false\n",
      "sensor.yaml");
  EXPECT_EQ(std::get<AutoExposure>(options.exposure).target_grey, 90);
  EXPECT_TRUE(std::holds_alternative<NoNoise>(options.noise));
  EXPECT_TRUE(options.bayer);
  const std::string text = write_settings(options);
  EXPECT_EQ(write_settings(read_settings_text<SensorOptions>(text, "sensor.yaml")), text);
}

TEST(CameraSensor, RefusesWhatNoSensorDoes) {
  try {
    read_settings_text<SensorOptions>(
        "exposure: {kind: auto, least_ms: 5, most_ms: 2}\nvignetting: 0.9\n"
        "noise: {kind: photons, full_well_e: 3}\nrow_us: -1\n",
        "sensor.yaml");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.lines(),
                ElementsAre("sensor.yaml:1:46: exposure.most_ms: must be >= least_ms, got 2",
                            "sensor.yaml:2:13: vignetting: must be from 0 to 0.7, got 0.9",
                            "sensor.yaml:3:37: noise.full_well_e: must be from 100 to 1e+06, "
                            "got 3",
                            "sensor.yaml:4:9: row_us: must be from 0 to 1000, got -1"));
  }
}

}  // namespace
}  // namespace panoptes::sim

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/renderer.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/sim/render/flag_world.h"

namespace panoptes::sim {
namespace {

constexpr double kDepth_m = 1e-3;    // 24 bits of depth between 3 cm and 10 m resolve 0.2 mm at 3 m
constexpr double kGreyLevels = 2.0;  // rounding of texture, light and product

cv::Vec3b at(const cv::Mat& bgr, const Vec2& px) {
  return bgr.at<cv::Vec3b>(static_cast<int>(std::lround(px.y())),
                           static_cast<int>(std::lround(px.x())));
}

Vec2 seen_at(const View& view, const Vec3& p_scene) {
  return view.intrinsics.project(view.T_scene_camera.inverse() * p_scene);
}

bool is_red(const cv::Vec3b& c) { return c[2] > 2 * c[1] && c[2] > 2 * c[0]; }
bool is_green(const cv::Vec3b& c) { return c[1] > 2 * c[0] && c[1] > 2 * c[2]; }
bool is_blue(const cv::Vec3b& c) { return c[0] > 2 * c[1] && c[0] > 2 * c[2]; }

TEST(Renderer, LeftIsLeftAndWritingIsNotMirrored) {
  Renderer renderer(flag_world());
  const View view = ahead();
  const Drawn drawn = renderer.draw(view);
  ASSERT_EQ(drawn.bgr.size(), cv::Size(kWidth_px, kHeight_px));
  EXPECT_TRUE(drawn.floor_label.empty());
  EXPECT_TRUE(drawn.depth_m.empty());
  // Its left half is the red one, as on the picture; blue is below.
  EXPECT_TRUE(is_red(at(drawn.bgr, seen_at(view, {2.8, 1.0, 0.6}))));
  EXPECT_TRUE(is_green(at(drawn.bgr, seen_at(view, {2.8, 0.6, 0.6}))));
  EXPECT_TRUE(is_blue(at(drawn.bgr, seen_at(view, {2.8, 1.0, 0.1}))));
  EXPECT_LT(seen_at(view, {2.8, 1.0, 0.6}).x(), kWidth_px / 2.0);
}

TEST(Renderer, EdgesFallWhereTheIntrinsicsSay) {
  Renderer renderer(flag_world());
  View view = ahead();
  view.intrinsics.cx_px += 7;  // off centre, so that a wrong sign shows
  view.intrinsics.cy_px -= 5;
  const cv::Mat bgr = renderer.draw(view).bgr;
  const double edge_px = seen_at(view, {2.8, 1.2, 0.6}).x();
  const double row_px = seen_at(view, {2.8, 1.2, 0.6}).y();
  EXPECT_TRUE(is_red(at(bgr, {std::ceil(edge_px), row_px})));
  EXPECT_FALSE(is_red(at(bgr, {std::ceil(edge_px) - 1, row_px})));
  const double top_px = seen_at(view, {2.8, 1.0, 0.8}).y();
  const double column_px = seen_at(view, {2.8, 1.0, 0.8}).x();
  EXPECT_TRUE(is_red(at(bgr, {column_px, std::ceil(top_px)})));
  EXPECT_FALSE(is_red(at(bgr, {column_px, std::ceil(top_px) - 1})));
}

TEST(Renderer, TheLabelIsTheFloorAndNothingElse) {
  Renderer renderer(flag_world());
  const View view = ahead(0.5, deg_to_rad(20));
  const Drawn drawn = renderer.draw(view, {.floor_label = true});
  const auto label = [&](const Vec3& p) {
    const Vec2 px = seen_at(view, p);
    return drawn.floor_label.at<std::uint8_t>(static_cast<int>(std::lround(px.y())),
                                              static_cast<int>(std::lround(px.x())));
  };
  EXPECT_EQ(label({1.5, 0, 0}), 255);
  EXPECT_EQ(label({2.8, 0.8, 0.4}), 0);
  EXPECT_EQ(drawn.floor_label.at<std::uint8_t>(0, kWidth_px - 1), 0);  // above the horizon: nothing
  EXPECT_EQ(cv::countNonZero((drawn.floor_label != 0) & (drawn.floor_label != 255)), 0);
  EXPECT_EQ(cv::norm(drawn.bgr, renderer.draw(view).bgr, cv::NORM_INF),
            0);  // same picture without it
}

TEST(Renderer, DepthIsMetresAlongTheAxis) {
  Renderer renderer(flag_world());
  const View view = ahead();
  const Drawn drawn = renderer.draw(view, {.depth = true});
  const auto depth = [&](const Vec2& px) {
    return drawn.depth_m.at<float>(static_cast<int>(std::lround(px.y())),
                                   static_cast<int>(std::lround(px.x())));
  };
  EXPECT_NEAR(depth(seen_at(view, {2.8, 0.8, 0.4})), 2.8, kDepth_m);
  EXPECT_EQ(depth({kWidth_px / 2.0, 0}), std::numeric_limits<float>::infinity());
  const int row = kHeight_px - 1;  // the floor below: the height over the ray's slope
  const double slope = view.intrinsics.ray(Vec2(80, row)).y();
  EXPECT_NEAR(depth({80.0, static_cast<double>(row)}), 0.5 / slope, kDepth_m);
}

TEST(Renderer, AmbientOneShowsAnOpenSurfaceAsItsPictureIs) {
  Renderer renderer(flag_world());
  const View view = ahead(0.5, deg_to_rad(40));
  const cv::Vec3b seen = at(renderer.draw(view).bgr, seen_at(view, {0.8, -0.2, 0}));
  EXPECT_NEAR(seen[0], kGrey[0], kGreyLevels);
}

TEST(Renderer, GainScalesLightNotItsRoot) {
  Renderer renderer(flag_world());
  View view = ahead(0.5, deg_to_rad(40));
  view.gain = 0.25;
  const cv::Vec3b seen = at(renderer.draw(view).bgr, seen_at(view, {0.8, -0.2, 0}));
  EXPECT_NEAR(seen[0], kGrey[0] / 2, kGreyLevels);
}

TEST(Renderer, PicturesOfOneRendererAreIndependent) {
  Renderer renderer(flag_world());
  const cv::Mat first = renderer.draw(ahead()).bgr;
  const cv::Mat kept = first.clone();
  View other = ahead(0.9, 0.3);
  other.intrinsics = pinhole(64, 48, deg_to_rad(60));
  EXPECT_EQ(renderer.draw(other).bgr.size(), cv::Size(64, 48));
  EXPECT_EQ(cv::norm(first, kept, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(renderer.draw(ahead()).bgr, kept, cv::NORM_INF), 0);
}

TEST(Renderer, TwoRenderersDoNotDisturbOneAnother) {
  Renderer one(flag_world());
  const cv::Mat before = one.draw(ahead()).bgr;
  World empty = flag_world();
  empty.objects.pop_back();
  Renderer two(empty);
  EXPECT_GT(cv::norm(two.draw(ahead()).bgr, before, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(one.draw(ahead()).bgr, before, cv::NORM_INF), 0);
}

TEST(Renderer, AnEmptyWorldIsBlack) {
  World world;
  world.objects.push_back({"nothing", {}, {}});
  Renderer renderer(world);
  EXPECT_EQ(cv::countNonZero(renderer.draw(ahead()).bgr.reshape(1)), 0);
}

/// What a process of its own says (see drawn_elsewhere.cc), because the drawing library reads its
/// settings once.
std::string drawn_elsewhere(const std::string& environment) {
  const std::string command = "env " + environment + " " + PANOPTES_DRAWN_ELSEWHERE;
  FILE* pipe = ::popen(command.c_str(), "r");
  std::string said;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) {
    said += static_cast<char>(c);
  }
  EXPECT_EQ(::pclose(pipe), 0);
  return said;
}

TEST(Renderer, SameBitsForAnyNumberOfThreads) {
  const std::string alone = drawn_elsewhere("LP_NUM_THREADS=0");
  EXPECT_THAT(alone, ::testing::StartsWith("LP_NUM_THREADS=0 pictures="));
  for (const std::string threads : {"1", "2", "3"}) {
    EXPECT_EQ(drawn_elsewhere("LP_NUM_THREADS=" + threads),
              "LP_NUM_THREADS=" + threads + alone.substr(alone.find(' ')));
  }
}

TEST(Renderer, TheProgramDecidesAboutThreadsWhereTheEnvironmentDoesNot) {
  EXPECT_THAT(drawn_elsewhere("-u LP_NUM_THREADS"),
              ::testing::StartsWith("LP_NUM_THREADS=2 pictures="));
}

TEST(Renderer, AMachineThatCannotDrawIsSaid) {
  EXPECT_EQ(
      drawn_elsewhere("MESA_GL_VERSION_OVERRIDE=2.1"),
      "no OpenGL 3.3 from OSMesa, so nothing can be drawn; install the package libosmesa6 and "
      "unset GALLIUM_DRIVER and MESA_GL_VERSION_OVERRIDE\n");
}

}  // namespace
}  // namespace panoptes::sim

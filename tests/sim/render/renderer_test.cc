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

/// Everything holds for our painter and for OpenGL's.
class RendererOf : public ::testing::TestWithParam<PainterKind> {
 protected:
  static RendererOptions by_painter() {
    RendererOptions options;
    options.painter = GetParam();
    return options;
  }
};

INSTANTIATE_TEST_SUITE_P(Painter, RendererOf,
                         ::testing::Values(PainterKind::kSoftware, PainterKind::kOsMesa),
                         [](const auto& painter) {
                           return painter.param == PainterKind::kSoftware ? "Software" : "OsMesa";
                         });

TEST_P(RendererOf, LeftIsLeftAndWritingIsNotMirrored) {
  Renderer renderer(flag_world(), by_painter());
  const View view = ahead();
  const RenderedImage rendered = renderer.draw(view);
  ASSERT_EQ(rendered.bgr.size(), cv::Size(kWidth_px, kHeight_px));
  EXPECT_TRUE(rendered.floor_label.empty());
  EXPECT_TRUE(rendered.depth_m.empty());
  // Its left half is the red one, as on the picture; blue is below.
  EXPECT_TRUE(is_red(at(rendered.bgr, seen_at(view, {2.8, 1.0, 0.6}))));
  EXPECT_TRUE(is_green(at(rendered.bgr, seen_at(view, {2.8, 0.6, 0.6}))));
  EXPECT_TRUE(is_blue(at(rendered.bgr, seen_at(view, {2.8, 1.0, 0.1}))));
  EXPECT_LT(seen_at(view, {2.8, 1.0, 0.6}).x(), kWidth_px / 2.0);
}

TEST_P(RendererOf, EdgesFallWhereTheIntrinsicsSay) {
  Renderer renderer(flag_world(), by_painter());
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

TEST_P(RendererOf, TheLabelIsTheFloorAndNothingElse) {
  Renderer renderer(flag_world(), by_painter());
  const View view = ahead(0.5, deg_to_rad(20));
  const RenderedImage rendered = renderer.draw(view, {.floor_label = true});
  const auto label = [&](const Vec3& p) {
    const Vec2 px = seen_at(view, p);
    return rendered.floor_label.at<std::uint8_t>(static_cast<int>(std::lround(px.y())),
                                                 static_cast<int>(std::lround(px.x())));
  };
  EXPECT_EQ(label({1.5, 0, 0}), 255);
  EXPECT_EQ(label({2.8, 0.8, 0.4}), 0);
  EXPECT_EQ(rendered.floor_label.at<std::uint8_t>(0, kWidth_px - 1),
            0);  // above the horizon: nothing
  EXPECT_EQ(cv::countNonZero((rendered.floor_label != 0) & (rendered.floor_label != 255)), 0);
  EXPECT_EQ(cv::norm(rendered.bgr, renderer.draw(view).bgr, cv::NORM_INF),
            0);  // same picture without it
}

TEST_P(RendererOf, DepthIsMetresAlongTheAxis) {
  Renderer renderer(flag_world(), by_painter());
  const View view = ahead();
  const RenderedImage rendered = renderer.draw(view, {.depth = true});
  const auto depth = [&](const Vec2& px) {
    return rendered.depth_m.at<float>(static_cast<int>(std::lround(px.y())),
                                      static_cast<int>(std::lround(px.x())));
  };
  EXPECT_NEAR(depth(seen_at(view, {2.8, 0.8, 0.4})), 2.8, kDepth_m);
  EXPECT_EQ(depth({kWidth_px / 2.0, 0}), std::numeric_limits<float>::infinity());
  const int row = kHeight_px - 1;  // the floor below: the height over the ray's slope
  const double slope = view.intrinsics.ray(Vec2(80, row)).y();
  EXPECT_NEAR(depth({80.0, static_cast<double>(row)}), 0.5 / slope, kDepth_m);
}

TEST_P(RendererOf, DepthIsAsExactFarAwayAsNear) {
  World world = flag_world();
  world.objects[1].triangles = box({299, -6, 0}, {300, 6, 12}, 1);
  Renderer renderer(world, by_painter());
  const float depth = renderer.draw(ahead(), {.depth = true}).depth_m.at<float>(58, 80);
  EXPECT_NEAR(depth, 299, 1e-5 * 299);  // a hundred ulps of its inverse
}

TEST_P(RendererOf, InstancesAreTheObjectsInTheirOrder) {
  World world = flag_world();
  for (int i = 0; i < 300; ++i) {  // more than fit into 8 bits
    world.objects.push_back(
        {"pebble", {}, box({1.0 + 0.001 * i, -3, 0}, {1.001 + 0.001 * i, -2, 0.01})});
  }
  world.objects.push_back({"last", {}, box({2, -0.5, 0}, {2.1, -0.2, 0.8})});
  Renderer renderer(world, by_painter());
  const View view = ahead();
  const RenderOutputs all{.floor_label = true, .depth = true, .instance = true};
  const RenderedImage rendered = renderer.draw(view, all);
  ASSERT_EQ(rendered.instance.type(), CV_16U);
  const auto instance = [&](const Vec3& p) {
    const Vec2 px = seen_at(view, p);
    return rendered.instance.at<std::uint16_t>(static_cast<int>(std::lround(px.y())),
                                               static_cast<int>(std::lround(px.x())));
  };
  EXPECT_EQ(instance({1.5, 0, 0}), 1);
  EXPECT_EQ(instance({2.8, 0.8, 0.4}), 2);
  EXPECT_EQ(instance({2, -0.3, 0.5}), world.objects.size());
  EXPECT_EQ(rendered.instance.at<std::uint16_t>(0, 0), 0);
  // Whatever is asked for besides, each is the same.
  EXPECT_EQ(cv::norm(rendered.bgr, renderer.draw(view).bgr, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(rendered.floor_label, renderer.draw(view, {.floor_label = true}).floor_label,
                     cv::NORM_INF),
            0);
  EXPECT_EQ(
      cv::norm(rendered.instance, renderer.draw(view, {.instance = true}).instance, cv::NORM_INF),
      0);
  // Nothing has no depth, everything has one.
  for (int row = 0; row < kHeight_px; ++row) {
    for (int column = 0; column < kWidth_px; ++column) {
      EXPECT_EQ(rendered.instance.at<std::uint16_t>(row, column) == 0,
                std::isinf(rendered.depth_m.at<float>(row, column)));
    }
  }
}

TEST_P(RendererOf, DepthAndInstanceAreThoseOfABoxByArithmetic) {
  Renderer renderer(flag_world(), by_painter());
  const View view = ahead(0.9, deg_to_rad(15));
  const RenderedImage rendered = renderer.draw(view, {.depth = true, .instance = true});
  const Vec3 eye = view.T_scene_camera.translation;
  int compared = 0;
  for (int row = 0; row < kHeight_px; row += 3) {
    for (int column = 0; column < kWidth_px; column += 3) {
      const Vec3 ray = view.T_scene_camera.rotation * view.intrinsics.ray(Vec2(column, row));
      // The box by its slabs, else the floor.
      double enter = 0;
      double leave = std::numeric_limits<double>::infinity();
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const double a = (Vec3(2.8, 0.4, 0)[axis] - eye[axis]) / ray[axis];
        const double b = (Vec3(3.2, 1.2, 0.8)[axis] - eye[axis]) / ray[axis];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
      }
      const double floor = -eye.z() / ray.z();
      const Vec3 on_floor_m = eye + floor * ray;
      const auto instance = rendered.instance.at<std::uint16_t>(row, column);
      const auto depth = static_cast<double>(rendered.depth_m.at<float>(row, column));
      constexpr double kEdge = 0.02;  // pixels on an edge may go either way
      if (leave - enter > kEdge) {
        EXPECT_EQ(instance, 2);
        EXPECT_NEAR(depth, enter, kDepth_m);
        ++compared;
      } else if (enter - leave > kEdge && floor > 0 &&
                 on_floor_m.cwiseAbs().head<2>().maxCoeff() < 4.9) {
        EXPECT_EQ(instance, 1);
        EXPECT_NEAR(depth, floor, kDepth_m);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 800);
}

TEST_P(RendererOf, TheSkyIsSeenWhereNothingIsAndGoesWithTheDay) {
  World world = flag_world();
  world.sky_bgr = {0.9, 0.5, 0.25};
  world.ambient_group = "day";
  Renderer renderer(world, by_painter());
  View view = ahead();
  EXPECT_EQ(renderer.draw(view).bgr.at<cv::Vec3b>(0, 0), cv::Vec3b(242, 180, 128));
  view.gain = 0.5;
  const SceneState evening{{}, {{"day", 0.5}}};
  const cv::Vec3b dark = renderer.draw(view, {}, evening).bgr.at<cv::Vec3b>(0, 0);
  EXPECT_NEAR(dark[0], 242 / 2, 1);
  EXPECT_NEAR(dark[2], 128 / 2, 1);
}

World chair_world() {
  World world = flag_world();
  world.ambient = 0.5;
  world.ambient_group = "day";
  world.lights = {{{0, 0, 2.5}, {0.5, 0.5}, {0, 0, -1}, 2.0, "lamps"}};
  world.objects[1].kind = Object::Kind::kMovable;
  world.objects[1].triangles = box({-0.2, -0.4, 0}, {0.2, 0.4, 0.8}, 1);
  world.objects[1].T_scene_object.translation = {3, 0.8, 0};
  return world;
}

TEST_P(RendererOf, WhatMovesIsSeenWhereItIs) {
  Renderer renderer(chair_world(), by_painter());
  const View view = ahead();
  const RenderOutputs outputs{.depth = true, .instance = true};
  const RenderedImage before = renderer.draw(view, outputs);
  // Turned about by 180 degrees and 1.6 m to the right: the flag is on every side.
  const SceneState moved{{{1, {Eigen::Quaterniond(0, 0, 0, 1), {3, -0.8, 0}}}}, {}};
  const RenderedImage after = renderer.draw(view, outputs, moved);
  const auto at_px = [&](const RenderedImage& rendered, const Vec3& p, std::uint16_t instance,
                         double depth_m) {
    const Vec2 px = seen_at(view, p);
    const cv::Point at(static_cast<int>(std::lround(px.x())),
                       static_cast<int>(std::lround(px.y())));
    EXPECT_EQ(rendered.instance.at<std::uint16_t>(at), instance);
    if (depth_m > 0) {
      EXPECT_NEAR(rendered.depth_m.at<float>(at), depth_m, kDepth_m);
    }
  };
  at_px(before, {2.8, 0.9, 0.6}, 2, 2.8);
  at_px(before, {2.8, -0.7, 0.6}, 0, 0);
  at_px(after, {2.8, -0.7, 0.6}, 2, 2.8);
  at_px(after, {2.8, 0.9, 0.6}, 0, 0);
  EXPECT_TRUE(is_red(at(after.bgr, seen_at(view, {2.8, -0.6, 0.6}))));
  EXPECT_TRUE(is_green(at(after.bgr, seen_at(view, {2.8, -1.0, 0.6}))));
}

TEST_P(RendererOf, APictureDependsOnItsMomentNotOnThoseBefore) {
  const World world = chair_world();
  Renderer renderer(world, by_painter());
  Renderer other(world, by_painter());
  const View view = ahead();
  const SceneState first{{{1, {Eigen::Quaterniond::Identity(), {2, 0.3, 0}}}}, {{"lamps", 0.2}}};
  const SceneState second{{{1, {Eigen::Quaterniond::Identity(), {2.5, 0, 0}}}}, {{"day", 0.7}}};
  const cv::Mat alone = other.draw(view, {}, second).bgr;
  const cv::Mat start = renderer.draw(view).bgr;
  EXPECT_GT(cv::norm(renderer.draw(view, {}, first).bgr, start, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(renderer.draw(view, {}, second).bgr, alone, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(renderer.draw(view).bgr, start, cv::NORM_INF), 0);
}

TEST_P(RendererOf, LampsThatGoOutLeaveTheDay) {
  Renderer renderer(chair_world(), by_painter());
  const View view = ahead(0.5, deg_to_rad(30));
  const Vec2 floor_px = seen_at(view, {1, -0.3, 0});
  const cv::Vec3b lit = at(renderer.draw(view).bgr, floor_px);
  const cv::Vec3b dark = at(renderer.draw(view, {}, {{}, {{"lamps", 0}}}).bgr, floor_px);
  EXPECT_NEAR(dark[0], kGrey[0] * std::sqrt(0.5), kGreyLevels);
  EXPECT_GT(lit[0], dark[0] + 10);
  const cv::Vec3b twice =
      at(renderer.draw(view, {}, {{}, {{"lamps", 0}, {"day", 2}}}).bgr, floor_px);
  EXPECT_NEAR(twice[0], kGrey[0], kGreyLevels);
}

TEST_P(RendererOf, WhatMovesIsDarkerAwayFromTheLamp) {
  Renderer renderer(chair_world(), by_painter());
  const auto brightness = [&](double x_m) {
    const View view = ahead();
    const SceneState scene_state{{{1, {Eigen::Quaterniond::Identity(), {x_m, 0, 0}}}},
                                 {{"day", 0.1}}};
    const RenderedImage rendered = renderer.draw(view, {.instance = true}, scene_state);
    return cv::mean(rendered.bgr, rendered.instance == 2)[2];
  };
  EXPECT_GT(brightness(1.5), 1.2 * brightness(4.5));
}

TEST_P(RendererOf, AMeshOfManyTrianglesOfManyColoursIsDrawn) {
  World world = flag_world();
  constexpr int kSide = 100;
  Object hill{"hill", {}, {}};
  for (int i = 0; i < kSide * kSide; ++i) {
    world.textures.push_back({"colour", cv::Mat(1, 1, CV_8UC3, cv::Scalar(i % 256, i / 256, 128))});
    const double x = 1 + 0.02 * (i % kSide);
    const double y = -1 + 0.02 * (i / kSide);
    const auto z = [](double px, double py) {
      return 0.1 + 0.05 * std::sin(9 * px) * std::cos(9 * py);
    };
    Triangle t;
    t.texture = static_cast<int>(world.textures.size()) - 1;
    t.corners[0].p_object = {x, y, z(x, y)};
    t.corners[1].p_object = {x + 0.02, y, z(x + 0.02, y)};
    t.corners[2].p_object = {x, y + 0.02, z(x, y + 0.02)};
    hill.triangles.push_back(t);
    t.corners[0].p_object = {x + 0.02, y + 0.02, z(x + 0.02, y + 0.02)};
    std::swap(t.corners[1], t.corners[2]);
    hill.triangles.push_back(t);
  }
  world.objects = {hill};
  Renderer renderer(world, by_painter());
  const View view = ahead(2, deg_to_rad(50));
  const RenderedImage rendered = renderer.draw(view, {.depth = true, .instance = true});
  int compared = 0;
  for (int k = 0; k < kSide * kSide; k += 37) {
    const Triangle& t = hill.triangles[static_cast<std::size_t>(2 * k)];
    const Vec3 middle = (t.corners[0].p_object + t.corners[1].p_object + t.corners[2].p_object) / 3;
    const Vec2 px = seen_at(view, middle);
    const bool on_rim = k % kSide % (kSide - 1) == 0 || k / kSide % (kSide - 1) == 0;
    if (on_rim || px.x() < 1 || px.y() < 1 || px.x() > kWidth_px - 2 || px.y() > kHeight_px - 2) {
      continue;
    }
    // Red is the same in all of them but for the light; blue tells the column.
    EXPECT_NEAR(at(rendered.bgr, px)[2], 128 * 0.97, 128 * 0.04);
    ++compared;
  }
  EXPECT_GT(compared, 50);
}

TEST_P(RendererOf, AmbientOneShowsAnOpenSurfaceAsItsPictureIs) {
  Renderer renderer(flag_world(), by_painter());
  const View view = ahead(0.5, deg_to_rad(40));
  const cv::Vec3b seen = at(renderer.draw(view).bgr, seen_at(view, {0.8, -0.2, 0}));
  EXPECT_NEAR(seen[0], kGrey[0], kGreyLevels);
}

TEST_P(RendererOf, GainScalesLightNotItsRoot) {
  Renderer renderer(flag_world(), by_painter());
  View view = ahead(0.5, deg_to_rad(40));
  view.gain = 0.25;
  const cv::Vec3b seen = at(renderer.draw(view).bgr, seen_at(view, {0.8, -0.2, 0}));
  EXPECT_NEAR(seen[0], kGrey[0] / 2, kGreyLevels);
}

TEST_P(RendererOf, PicturesOfOneRendererAreIndependent) {
  Renderer renderer(flag_world(), by_painter());
  const cv::Mat first = renderer.draw(ahead()).bgr;
  const cv::Mat kept = first.clone();
  View other = ahead(0.9, 0.3);
  other.intrinsics = pinhole(64, 48, deg_to_rad(60));
  EXPECT_EQ(renderer.draw(other).bgr.size(), cv::Size(64, 48));
  EXPECT_EQ(cv::norm(first, kept, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(renderer.draw(ahead()).bgr, kept, cv::NORM_INF), 0);
}

TEST_P(RendererOf, TwoRenderersDoNotDisturbOneAnother) {
  Renderer one(flag_world(), by_painter());
  const cv::Mat before = one.draw(ahead()).bgr;
  World empty = flag_world();
  empty.objects.pop_back();
  Renderer two(empty, by_painter());
  EXPECT_GT(cv::norm(two.draw(ahead()).bgr, before, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(one.draw(ahead()).bgr, before, cv::NORM_INF), 0);
}

TEST_P(RendererOf, AnEmptyWorldIsBlack) {
  World world;
  world.objects.push_back({"nothing", {}, {}});
  Renderer renderer(world, by_painter());
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
  for (const std::string painter : {"software", "osmesa"}) {
    const auto with_threads = [&painter](const std::string& threads) {
      return drawn_elsewhere("PANOPTES_TEST_PAINTER=" + painter +
                             " PANOPTES_TEST_THREADS=" + threads);
    };
    const std::string alone = with_threads("1");
    EXPECT_THAT(alone, ::testing::StartsWith("threads=1 LP_NUM_THREADS=1 pictures="));
    for (const std::string threads : {"2", "3"}) {
      EXPECT_EQ(with_threads(threads), "threads=" + threads + " LP_NUM_THREADS=" + threads +
                                           alone.substr(alone.find(" pictures=")));
    }
  }
}

TEST(Renderer, TheEnvironmentsThreadsAreThoseOfOpenGlAlone) {
  EXPECT_THAT(drawn_elsewhere("LP_NUM_THREADS=3 PANOPTES_TEST_THREADS=2"),
              ::testing::StartsWith("threads=2 LP_NUM_THREADS=3 pictures="));
}

std::string pictures_of(const std::string& said) { return said.substr(said.find("pictures=")); }

TEST(Renderer, EglDrawsTheSameBits) {
  const std::string rendered = drawn_elsewhere("PANOPTES_TEST_PAINTER=egl LIBGL_ALWAYS_SOFTWARE=1");
  if (rendered.find("pictures=") == std::string::npos) {
    GTEST_SKIP() << rendered;
  }
  EXPECT_EQ(pictures_of(rendered), pictures_of(drawn_elsewhere("PANOPTES_TEST_PAINTER=osmesa")));
}

TEST(Renderer, BothContextsTakeTurnsInOneProcess) {
  const std::string both =
      drawn_elsewhere("'PANOPTES_TEST_PAINTER=osmesa and egl' LIBGL_ALWAYS_SOFTWARE=1");
  if (both.find("pictures=") == std::string::npos) {
    GTEST_SKIP() << both;
  }
  EXPECT_EQ(pictures_of(both), pictures_of(drawn_elsewhere("PANOPTES_TEST_PAINTER=osmesa")));
}

TEST(Renderer, OurPainterDrawsTheSameBitsWithAnyInstructions) {
  EXPECT_EQ(drawn_elsewhere("PANOPTES_TEST_SAME=1"), drawn_elsewhere(""));
}

TEST(Renderer, OpenGlDrawsTheSameBitsOnEveryProcessorWhereThatIsAskedFor) {
  const std::string painter = "PANOPTES_TEST_PAINTER=osmesa ";
  const std::string here = drawn_elsewhere(painter + "PANOPTES_TEST_SAME=1");
  // As wide as the narrowest processor's vectors, and as wide as this one's.
  for (const std::string bits : {"128", "256"}) {
    EXPECT_EQ(drawn_elsewhere(painter + "PANOPTES_TEST_SAME=1 LP_NATIVE_VECTOR_WIDTH=" + bits),
              here);
  }
  // The environment says the same.
  EXPECT_EQ(drawn_elsewhere(painter + "GALLIUM_OVERRIDE_CPU_CAPS=sse4.1"), here);
}

TEST(Renderer, AMachineThatCannotDrawIsSaid) {
  EXPECT_EQ(
      drawn_elsewhere("PANOPTES_TEST_PAINTER=osmesa MESA_GL_VERSION_OVERRIDE=2.1"),
      "no OpenGL 4.5 from OSMesa, so nothing can be drawn; install the package libosmesa6 and "
      "unset GALLIUM_DRIVER and MESA_GL_VERSION_OVERRIDE\n");
}

}  // namespace
}  // namespace panoptes::sim

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/lightmap.h"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/sim/world/boxes.h"

namespace panoptes::sim {
namespace {

namespace fs = std::filesystem;
constexpr double kCell_m = 0.1;

World lamp_world() {
  World world;
  world.ambient = 0.3;
  world.lights = {{{0, 0, 2}, {0.2, 0.2}, {0, 0, -1}, 2.0, ""}};
  world.textures = {{"white", cv::Mat(1, 1, CV_8UC3, cv::Scalar(255, 255, 255))}};
  world.objects = {{"floor", {}, floor_sheet()}, {"table", {}, box({2, -0.5, 0.6}, {3, 0.5, 0.7})}};
  return world;
}

double light_on(const cv::Mat& texels, const Chart& chart, const Vec3& p_scene) {
  const Vec3 p = p_scene - chart.origin_scene;
  const int column =
      static_cast<int>(std::lround(chart.u.dot(p) / chart.size_m.x() * (chart.columns - 1)));
  const int row =
      static_cast<int>(std::lround(chart.v.dot(p) / chart.size_m.y() * (chart.rows - 1)));
  const double root = texels.at<std::uint8_t>(chart.row + row, chart.column + column) / 255.0;
  return kMostLight * root * root;
}

TEST(Charts, ConnectedTrianglesOfOnePlaneShareOne) {
  const Charts charts = make_charts(lamp_world(), kCell_m);
  ASSERT_EQ(charts.charts.size(), 1U + 6U);  // the floor and the sides of the box
  for (const Chart& chart : charts.charts) {
    EXPECT_EQ(chart.triangles.size(), 2U);
    EXPECT_GE(chart.columns, 2);
  }
  EXPECT_EQ(charts.charts[0].columns, 101);  // 10 m every 0.1 m, both ends
}

TEST(Charts, LieInsideTheLightmapWithoutOverlap) {
  const Charts charts = make_charts(lamp_world(), kCell_m);
  cv::Mat taken = cv::Mat::zeros(charts.rows, charts.columns, CV_8U);
  for (const Chart& chart : charts.charts) {
    ASSERT_LE(chart.column + chart.columns, charts.columns);
    ASSERT_LE(chart.row + chart.rows, charts.rows);
    cv::Mat place = taken(cv::Rect(chart.column, chart.row, chart.columns, chart.rows));
    EXPECT_EQ(cv::countNonZero(place), 0);
    place.setTo(1);
    for (const LitTriangle& t : chart.triangles) {
      for (const Vec2& texel : t.texel) {
        EXPECT_GE(texel.x(), chart.column - 1e-9);
        EXPECT_LE(texel.x(), chart.column + chart.columns - 1 + 1e-9);
        EXPECT_GE(texel.y(), chart.row - 1e-9);
        EXPECT_LE(texel.y(), chart.row + chart.rows - 1 + 1e-9);
      }
    }
  }
}

TEST(Bake, LightFallsWithTheSquareOfTheDistanceAndTheCosines) {
  const World world = lamp_world();
  const Charts charts = make_charts(world, kCell_m);
  const cv::Mat texels = bake_light(world, charts, 1);
  // A lamp of 0.2 m at 2 m is a point to 1 %; a level of 255 at this light is 1.3 % of it.
  constexpr double kShare = 0.025;
  const auto expected = [](double side_m) {
    const double r2 = 4 + side_m * side_m;
    return 0.3 + 2.0 * (2 / std::sqrt(r2)) * (2 / std::sqrt(r2)) / r2;
  };
  EXPECT_NEAR(light_on(texels, charts.charts[0], {0, 0, 0}), expected(0), kShare * expected(0));
  EXPECT_NEAR(light_on(texels, charts.charts[0], {-2, 0, 0}), expected(2), kShare * expected(2));
}

TEST(Bake, ShadowsAndNearThingsDarkenButNothingIsBlack) {
  const World world = lamp_world();
  const Charts charts = make_charts(world, kCell_m);
  const cv::Mat texels = bake_light(world, charts, 1);
  const double open = light_on(texels, charts.charts[0], {-3, 0, 0});
  const double shadow = light_on(texels, charts.charts[0], {4.3, 0, 0});  // the table is in between
  EXPECT_LT(shadow, open);
  EXPECT_NEAR(shadow, 0.3, 0.01);                                           // ambient alone
  const double beneath = light_on(texels, charts.charts[0], {2.95, 0, 0});  // and the table above
  EXPECT_LT(beneath, shadow);
  EXPECT_GT(beneath, 0.05);
}

TEST(Bake, NothingLeaksOutFromUnderWhatStandsOnTheFloor) {
  World world = lamp_world();
  world.lights.clear();
  world.objects[1].triangles = box({1, 1, 0}, {2, 2, 1});
  const Charts charts = make_charts(world, kCell_m);
  const cv::Mat texels = bake_light(world, charts, 1);
  // Inside of the box the floor takes on what is around it.
  const double around = light_on(texels, charts.charts[0], {0.9, 1.5, 0});
  const double inside = light_on(texels, charts.charts[0], {1.5, 1.5, 0});
  EXPECT_NEAR(inside, around, 0.3 * around);
  EXPECT_GT(inside, 0.1);
}

TEST(Bake, SameBitsForAnyNumberOfThreads) {
  const World world = lamp_world();
  const Charts charts = make_charts(world, kCell_m);
  const cv::Mat alone = bake_light(world, charts, 1);
  for (const int threads : {2, 5}) {
    EXPECT_EQ(cv::norm(bake_light(world, charts, threads), alone, cv::NORM_INF), 0);
  }
}

/// $XDG_CACHE_HOME while it lives.
class CacheHome {
 public:
  explicit CacheHome(const std::string& folder) {
    if (const char* before = std::getenv("XDG_CACHE_HOME")) {
      before_ = before;
    }
    ::setenv("XDG_CACHE_HOME", folder.c_str(), 1);
  }
  ~CacheHome() {
    before_.empty() ? ::unsetenv("XDG_CACHE_HOME") : ::setenv("XDG_CACHE_HOME", before_.c_str(), 1);
  }

 private:
  std::string before_;
};

TEST(LightCache, KeepsWhatWasBakedAndMendsWhatIsBroken) {
  const fs::path folder = fs::path(::testing::TempDir()) / "panoptes-light-cache";
  fs::remove_all(folder);
  const CacheHome home(folder.string());
  const World world = lamp_world();
  const Charts charts = make_charts(world, kCell_m);
  const cv::Mat baked = cached_light(world, charts, 1);
  ASSERT_EQ(std::distance(fs::directory_iterator(folder / "panoptes"), {}), 1);
  const fs::path file = fs::directory_iterator(folder / "panoptes")->path();
  const auto written = fs::last_write_time(file);
  EXPECT_EQ(cv::norm(cached_light(world, charts, 1), baked, cv::NORM_INF), 0);
  EXPECT_EQ(fs::last_write_time(file), written);

  fs::resize_file(file, 20);
  EXPECT_EQ(cv::norm(cached_light(world, charts, 1), baked, cv::NORM_INF), 0);
  EXPECT_GT(fs::file_size(file), 20U);

  World brighter = world;
  brighter.ambient = 0.6;
  EXPECT_GT(cv::norm(cached_light(brighter, charts, 1), baked, cv::NORM_INF), 0);
  fs::remove_all(folder);
}

TEST(LightCache, DoesWithoutAFolder) {
  const fs::path file = fs::path(::testing::TempDir()) / "panoptes-no-folder";
  std::ofstream(file) << "a file where a folder should be";
  const CacheHome home(file.string());
  const World world = lamp_world();
  const Charts charts = make_charts(world, kCell_m);
  EXPECT_EQ(cv::norm(cached_light(world, charts, 1), bake_light(world, charts, 1), cv::NORM_INF),
            0);
  fs::remove(file);
}

}  // namespace
}  // namespace panoptes::sim

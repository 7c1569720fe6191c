// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/lightmap.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "sim/render/renderer.h"
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
  const Vec3 p = p_scene - chart.origin;
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

/// The light of all groups together.
cv::Mat baked(const World& world, const Charts& charts, int threads = 1) {
  const BakedLight light = bake_light(world, charts, threads);
  EXPECT_EQ(light.layers.size(), 1U);
  return light.layers.at(0);
}

cv::Mat cached(const World& world, const Charts& charts) {
  return cached_light(world, charts, 1).layers.at(0);
}

TEST(Charts, AnythingSmallHasOneTexelAndAHugeWorldNoMoreThanAMillion) {
  World world = lamp_world();
  world.objects[1].triangles = box({0, 0, 0}, {0.02, 0.02, 0.02});
  Charts charts = make_charts(world, kCell_m);
  EXPECT_EQ(charts.charts[1].columns * charts.charts[1].rows, 1);
  EXPECT_EQ(charts.cell_m, kCell_m);
  for (Triangle& t : world.objects[0].triangles) {
    for (Corner& corner : t.corners) {
      corner.p_object *= 30;  // 300 x 300 m
    }
  }
  charts = make_charts(world, 0.05);
  EXPECT_GT(charts.cell_m, 0.05);
  EXPECT_LE(1LL * charts.charts[0].columns * charts.charts[0].rows, 1LL << 20);
  EXPECT_GE(1LL * charts.charts[0].columns * charts.charts[0].rows, 1LL << 19);
}

TEST(Charts, LinesAndPointsAreNoSurface) {
  World world = lamp_world();
  Triangle line = world.objects[0].triangles[0];
  line.corners[1] = line.corners[0];
  world.objects.push_back({"line", {}, {line}});
  EXPECT_EQ(make_charts(world, kCell_m).charts.size(), 1U + 6U);
}

TEST(Charts, ManyTrianglesOnOneEdgeAreAsManyChartsAsTheyFaceWays) {
  World world;
  world.textures = {{"white", cv::Mat(1, 1, CV_8UC3, cv::Scalar(255, 255, 255))}};
  Object fan{"fan", {}, {}};
  constexpr int kLeaves = 90;  // 4 degrees apart: none is in the plane of another
  constexpr int kCopies = 200;
  for (int i = 0; i < kLeaves * kCopies; ++i) {
    const double angle = deg_to_rad(4.0 * (i % kLeaves));
    Triangle t;
    t.corners[1].p_object = {0, 0, 1};
    t.corners[2].p_object = {std::cos(angle), std::sin(angle), 0};
    fan.triangles.push_back(t);
  }
  world.objects = {fan};
  const Charts charts = make_charts(world, kCell_m);
  ASSERT_EQ(charts.charts.size(), static_cast<std::size_t>(kLeaves));
  for (const Chart& chart : charts.charts) {
    EXPECT_EQ(chart.triangles.size(), static_cast<std::size_t>(kCopies));
  }
}

TEST(Charts, WhatMovesLiesApartAndInItsOwnFrame) {
  World world = lamp_world();
  world.objects[0].kind = Object::Kind::kMovable;
  world.objects[0].T_scene_object.translation.x() = 7;
  const Charts charts = make_charts(world, kCell_m);
  ASSERT_EQ(charts.charts.size(), 1U + 6U);
  const Chart& moving = charts.charts.back();
  EXPECT_TRUE(moving.moves);
  EXPECT_EQ(moving.object, 0U);
  EXPECT_LE(moving.triangles[0].p[0].x(), 5);
  for (std::size_t c = 0; c + 1 < charts.charts.size(); ++c) {
    EXPECT_FALSE(charts.charts[c].moves);
    EXPECT_LE(charts.charts[c].row + charts.charts[c].rows, moving.row);
  }
}

TEST(Bake, LightFallsWithTheSquareOfTheDistanceAndTheCosines) {
  const World world = lamp_world();
  const Charts charts = make_charts(world, kCell_m);
  const cv::Mat texels = baked(world, charts);
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
  const cv::Mat texels = baked(world, charts);
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
  const cv::Mat texels = baked(world, charts);
  // Inside of the box the floor takes on what is around it.
  const double around = light_on(texels, charts.charts[0], {0.9, 1.5, 0});
  const double inside = light_on(texels, charts.charts[0], {1.5, 1.5, 0});
  EXPECT_NEAR(inside, around, 0.3 * around);
  EXPECT_GT(inside, 0.1);
}

TEST(Bake, SameBitsForAnyNumberOfThreads) {
  const World world = lamp_world();
  const Charts charts = make_charts(world, kCell_m);
  const cv::Mat alone = baked(world, charts);
  for (const int threads : {2, 5}) {
    EXPECT_EQ(cv::norm(baked(world, charts, threads), alone, cv::NORM_INF), 0);
  }
}

TEST(Bake, TheSunShinesWithTheCosineAndThrowsHardShadows) {
  World world = lamp_world();
  world.lights.clear();
  const Vec3 from = Vec3(1, 0, 1).normalized();
  world.sun = {5 * from, 1.2, ""};
  const Charts charts = make_charts(world, kCell_m);
  const cv::Mat texels = baked(world, charts);
  constexpr double kLevel = 0.02;  // of 255 at this light
  EXPECT_NEAR(light_on(texels, charts.charts[0], {-3, 0, 0}), 0.3 + 1.2 * from.z(), kLevel);
  // The table's top at 0.7 m, from x = 2 to 3, darkens the floor from 1.3 to 2.4.
  EXPECT_NEAR(light_on(texels, charts.charts[0], {1.5, 0, 0}), 0.3, kLevel);
  EXPECT_NEAR(light_on(texels, charts.charts[0], {1.1, 0, 0}), 0.3 + 1.2 * from.z(), kLevel);
}

TEST(Bake, EachGroupOfLightsHasItsLayer) {
  World world = lamp_world();
  const Charts charts = make_charts(world, kCell_m);
  const cv::Mat together = baked(world, charts);
  world.lights[0].group = "lamps";
  world.ambient_group = "day";
  const BakedLight apart = bake_light(world, charts, 1);
  EXPECT_THAT(apart.groups, ::testing::ElementsAre("day", "lamps"));
  constexpr double kLevels = 0.04;  // two roundings
  for (const double x_m : {-4.0, -1.0, 0.0, 2.9, 4.3}) {
    const Vec3 p(x_m, 0, 0);
    const double day = light_on(apart.layers[0], charts.charts[0], p);
    const double lamps = light_on(apart.layers[1], charts.charts[0], p);
    EXPECT_NEAR(day + lamps, light_on(together, charts.charts[0], p), kLevels);
    EXPECT_LE(day, 0.31);
  }
}

TEST(Bake, ALampThatIsOutIsASurfaceLikeOthers) {
  World world = lamp_world();
  world.lights[0].group = "lamps";
  world.objects.push_back({"lamp", {}, box({-0.1, -0.1, 2}, {0.1, 0.1, 2.1})});
  const Charts charts = make_charts(world, 0.02);
  const BakedLight light = bake_light(world, charts, 1);
  const Chart* face = nullptr;
  for (const Chart& chart : charts.charts) {
    if (chart.object == 2 && chart.normal.z() < -0.5) {
      face = &chart;
    }
  }
  ASSERT_NE(face, nullptr);
  const double day = light_on(light.layers[0], *face, {0, 0, 2});
  const double lamps = light_on(light.layers[1], *face, {0, 0, 2});
  EXPECT_GT(day + lamps, 1.3);  // overexposed
  EXPECT_NEAR(day, 0.3, 0.02);
}

TEST(Bake, TheAirIsBrighterOnTheSideOfTheLamp) {
  World world = lamp_world();
  world.objects.push_back({"chair", {}, box({-0.2, -0.2, 0}, {0.2, 0.2, 1})});
  world.objects.back().kind = Object::Kind::kMovable;
  const Charts charts = make_charts(world, kCell_m);
  const BakedLight light = bake_light(world, charts, 2);
  const Probes& probes = light.probes;
  ASSERT_GT(probes.size(), 0U);
  ASSERT_EQ(probes.groups.size(), 1U);
  ASSERT_EQ(probes.groups[0].size(), probes.size());
  int above_is_brighter = 0;
  for (const Probes::Cube& cube : probes.groups[0]) {
    above_is_brighter += cube[4] > cube[5] ? 1 : 0;
    EXPECT_GT(*std::min_element(cube.begin(), cube.end()), 0);
  }
  EXPECT_GT(above_is_brighter, 0.95 * static_cast<double>(probes.size()));  // all but at the table
}

TEST(Bake, CanBeStoppedAndSaysHowFarItIs) {
  const World world = lamp_world();
  const Charts charts = make_charts(world, kCell_m);
  double last = 0;
  bool rose = true;
  bake_light(world, charts, 2, [&](double done) {
    rose = rose && done >= last && done <= 1;
    last = done;
    return true;
  });
  EXPECT_TRUE(rose);
  EXPECT_GT(last, 0.3);
  int calls = 0;
  EXPECT_THROW(bake_light(world, charts, 2,
                          [&calls](double /*done*/) {
                            ++calls;
                            return false;
                          }),
               BakeStopped);
  EXPECT_EQ(calls, 1);
  struct Thrown {};
  EXPECT_THROW(bake_light(world, charts, 2, [](double /*done*/) -> bool { throw Thrown(); }),
               Thrown);
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
  const cv::Mat first = cached(world, charts);
  ASSERT_EQ(std::distance(fs::directory_iterator(folder / "panoptes"), {}), 1);
  const fs::path file = fs::directory_iterator(folder / "panoptes")->path();
  const auto written = fs::last_write_time(file);
  EXPECT_EQ(cv::norm(cached(world, charts), first, cv::NORM_INF), 0);
  EXPECT_EQ(fs::last_write_time(file), written);

  fs::resize_file(file, 20);
  EXPECT_EQ(cv::norm(cached(world, charts), first, cv::NORM_INF), 0);
  EXPECT_GT(fs::file_size(file), 20U);

  World brighter = world;
  brighter.ambient = 0.6;
  EXPECT_GT(cv::norm(cached(brighter, charts), first, cv::NORM_INF), 0);
  fs::remove_all(folder);
}

TEST(LightCache, KeepsGroupsAndTheLightInTheAir) {
  const fs::path folder = fs::path(::testing::TempDir()) / "panoptes-light-cache-groups";
  fs::remove_all(folder);
  const CacheHome home(folder.string());
  World world = lamp_world();
  world.lights[0].group = "lamps";
  world.objects[1].kind = Object::Kind::kMovable;
  const Charts charts = make_charts(world, kCell_m);
  const BakedLight fresh = cached_light(world, charts, 1);
  const BakedLight again =
      cached_light(world, charts, 1, [](double /*done*/) { return false; });  // not baked
  EXPECT_EQ(again.groups, fresh.groups);
  ASSERT_EQ(again.layers.size(), fresh.layers.size());
  for (std::size_t g = 0; g < fresh.layers.size(); ++g) {
    EXPECT_EQ(cv::norm(again.layers[g], fresh.layers[g], cv::NORM_INF), 0);
  }
  EXPECT_EQ(again.probes.counts, fresh.probes.counts);
  EXPECT_EQ(again.probes.low_scene, fresh.probes.low_scene);
  EXPECT_EQ(again.probes.spacing_m, fresh.probes.spacing_m);
  EXPECT_EQ(again.probes.groups, fresh.probes.groups);
  fs::remove_all(folder);
}

TEST(LightCache, DoesWithoutAFolder) {
  const fs::path file = fs::path(::testing::TempDir()) / "panoptes-no-folder";
  std::ofstream(file) << "a file where a folder should be";
  const CacheHome home(file.string());
  const World world = lamp_world();
  const Charts charts = make_charts(world, kCell_m);
  EXPECT_EQ(cv::norm(cached(world, charts), baked(world, charts), cv::NORM_INF), 0);
  fs::remove(file);
}

}  // namespace
}  // namespace panoptes::sim

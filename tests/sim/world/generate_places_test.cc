// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "sim/physics/obstacles.h"
#include "sim/world/generate.h"
#include "sim/world/layers.h"
#include "sim/world/load.h"

namespace panoptes::sim {
namespace {

using ::testing::Eq;
using ::testing::Ge;
using ::testing::Gt;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Le;
using ::testing::Lt;

constexpr double kRobotRadius_m = 0.25;
constexpr double kRobotHeight_m = 0.8;
// Half a passage of 0.9 m, which the grid of FreeRegion may miss by half of its cells of 5 cm.
constexpr double kHalfPassage_m = 0.42;

template <class Plan>
WorldSettings made(const Plan& plan) {
  WorldSettings settings;
  settings.name = std::string(Plan::kName);
  settings.generate = plan;
  return expanded(settings);
}

template <class Plan>
Plan with_seed(std::uint64_t seed, Plan plan = {}) {
  plan.seed = seed;
  return plan;
}

std::string description(const WorldSettings& settings) {
  std::string all;
  const auto pose = [](const Pose2& at) {
    return fmt::format("{} {} {}", at.x_m, at.y_m, at.theta_rad);
  };
  for (const BoxSettings& box : settings.boxes) {
    all += fmt::format("{} {} {} {} {} {} {}\n", box.name, box.size_m.x(), box.size_m.y(),
                       box.size_m.z(), pose(box.at), box.z_m, box.picture);
  }
  for (const ObjectSettings& object : settings.objects) {
    all += fmt::format("{} {} {} {} {}\n", object.name, object.mesh, pose(object.at), object.z_m,
                       object.movable);
  }
  for (const AreaLight& light : settings.lights) {
    all += fmt::format("{} {} {}\n", light.at_m.x(), light.at_m.y(), light.power);
  }
  for (const EventSettings& event : settings.events) {
    all += fmt::format("{} {} {}\n", event.at_s, event.over_s, event.power);
  }
  return all;
}

// Corners so small that the robot's middle has less room in them are not worth a way on a grid.
constexpr double kCorner_m = 0.15;

/// Floor of a world where the robot fits, in a raster of `step_m`, that is in no one piece with the
/// rest of such floor; nothing is looked for in the outer `margin_m`.
std::vector<Vec2> cut_off(const Obstacles& obstacles, double step_m, double margin_m = 0) {
  const FreeRegion region(obstacles, kRobotRadius_m);
  const auto is_reached = [&region](const Vec2& p) {
    for (const double radius_m : {0.0, kCorner_m / 2, kCorner_m}) {
      for (int k = 0; k < 8; ++k) {
        const double a = k * std::numbers::pi / 4;
        if (region.contains(p + radius_m * Vec2(std::cos(a), std::sin(a)))) {
          return true;
        }
      }
    }
    return false;
  };
  std::vector<Vec2> lost;
  const Vec2 margin = Vec2(1, 1) * (margin_m + kRobotRadius_m);
  const Vec2 low = obstacles.low_scene() + margin;
  const Vec2 high = obstacles.high_scene() - margin;
  for (double y = low.y(); y < high.y(); y += step_m) {
    for (double x = low.x(); x < high.x(); x += step_m) {
      const Vec2 p(x, y);
      if (!obstacles.nearest(p, kRobotRadius_m) && !is_reached(p)) {
        lost.push_back(p);
      }
    }
  }
  return lost;
}

std::string places(const std::vector<Vec2>& points) {
  std::string all;
  for (const Vec2& p : points) {
    all += fmt::format("({:.2f}, {:.2f}) ", p.x(), p.y());
  }
  return all;
}

std::size_t triangles_of(const World& world) {
  std::size_t count = 0;
  for (const Object& object : world.objects) {
    count += object.triangles.size();
  }
  return count;
}

/// Everything hangs together, in passages of 0.9 m for the most part.
void expect_one_piece(const World& world, double step_m, double least_m2) {
  const Obstacles obstacles(outlines(world, kFloorLayerTop_m, kRobotHeight_m));
  EXPECT_EQ(places(cut_off(obstacles, step_m)), "");
  const double area_m2 = FreeRegion(obstacles, kRobotRadius_m).area_m2();
  const double wide_m2 = FreeRegion(obstacles, kHalfPassage_m).area_m2();
  EXPECT_THAT(area_m2, Gt(least_m2));
  // A disc of twice the area still gets around in a good part of it: no door is too narrow for it.
  EXPECT_THAT(wide_m2, Gt(0.45 * area_m2));
}

TEST(GeneratedPlaces, AreTheSameForTheSamePlanAndOthersForAnotherSeed) {
  const auto check = [](const auto& plan) {
    using Plan = std::decay_t<decltype(plan)>;
    const std::string once = description(made(plan));
    EXPECT_EQ(once, description(made(plan)));
    EXPECT_NE(once, description(made(with_seed<Plan>(plan.seed + 1, plan))));
  };
  check(HomePlan{});
  check(CorridorsPlan{});
  check(WarehousePlan{});
  check(StreetPlan{});
  const std::string room = description(made(RoomPlan{.seed = 5}));
  EXPECT_EQ(room, description(made(RoomPlan{.seed = 5})));
  EXPECT_NE(room, description(made(RoomPlan{.seed = 6})));
}

TEST(GeneratedPlaces, SmallRoomsHaveAPlaceToStartAndHangTogether) {
  constexpr double kRaster_m = 0.05;
  constexpr double kStart_m = 0.7;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    const World world = make_world(made(RoomPlan{.seed = seed}));
    const Obstacles obstacles(outlines(world, kFloorLayerTop_m, kRobotHeight_m));
    // Between things that stand about there may be a place for the body, but no room to speak of.
    constexpr double kPockets_m2 = 0.1;
    const std::vector<Vec2> lost = cut_off(obstacles, kRaster_m);
    EXPECT_THAT(static_cast<double>(lost.size()) * kRaster_m * kRaster_m, Lt(kPockets_m2))
        << places(lost);
    const FreeRegion region(obstacles, kRobotRadius_m);
    const Vec2 low = obstacles.low_scene();
    const Vec2 high = obstacles.high_scene();
    int starts = 0;
    for (double y = low.y(); y < high.y(); y += kRaster_m) {
      for (double x = low.x(); x < high.x(); x += kRaster_m) {
        starts += region.contains({x, y}) && !obstacles.nearest({x, y}, kStart_m) ? 1 : 0;
      }
    }
    EXPECT_THAT(starts, Gt(0));
    EXPECT_THAT((high - low).minCoeff(), Gt(4));
    EXPECT_THAT((high - low).maxCoeff(), Lt(6.5));
    EXPECT_THAT(triangles_of(world), Le(10000U));
  }
}

TEST(GeneratedPlaces, SmallRoomsAreAsLargeAsTheyAreToBeDrawnWithAPlaceToStartAsClear) {
  constexpr double kClear_m = 0.95;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    const World world = make_world(
        made(RoomPlan{.drawn_size_m = Vec2(5, 6), .start_clear_m = kClear_m, .seed = seed}));
    const Obstacles obstacles(outlines(world, kFloorLayerTop_m, kRobotHeight_m));
    const Vec2 low = obstacles.low_scene();
    const Vec2 high = obstacles.high_scene();
    EXPECT_THAT((high - low).minCoeff(), Gt(5));
    EXPECT_THAT((high - low).maxCoeff(), Lt(6.5));
    int starts = 0;
    for (double y = low.y(); y < high.y(); y += 0.05) {
      for (double x = low.x(); x < high.x(); x += 0.05) {
        starts += obstacles.nearest({x, y}, kClear_m) ? 0 : 1;
      }
    }
    EXPECT_THAT(starts, Gt(0));
  }
}

TEST(GeneratedPlaces, ARoomThatIsAlikeIsTheSameAfterHalfATurn) {
  const Vec2 size(6, 5);
  const WorldSettings room = made(RoomPlan{.size_m = size, .alike = true, .seed = 4});
  EXPECT_THAT(room.objects.size(), Gt(20));
  for (const ObjectSettings& object : room.objects) {
    const auto like =
        std::count_if(room.objects.begin(), room.objects.end(), [&](const ObjectSettings& other) {
          return other.mesh == object.mesh &&
                 (other.at.position() - (size - object.at.position())).norm() < 1e-9;
        });
    EXPECT_THAT(like, Ge(1)) << object.name;
  }
  std::set<std::string> paintings;
  for (const ObjectSettings& object : room.objects) {
    if (object.mesh.find("painting") != std::string::npos) {
      paintings.insert(object.mesh);
    }
  }
  EXPECT_THAT(paintings.size(), Eq(1));
}

TEST(GeneratedPlaces, SmallRoomsAreAsClutteredAndAsBareAsIsSaid) {
  const auto things = [](double clutter) {
    std::size_t count = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      count +=
          made(RoomPlan{.size_m = Vec2(5.5, 5), .clutter = clutter, .seed = seed}).objects.size();
    }
    return count;
  };
  EXPECT_THAT(things(1), Gt(things(0) + 30));
  const auto plain = [](double blank) {
    double plain_m = 0;
    double all_m = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      for (const BoxSettings& box : made(RoomPlan{.blank = blank, .seed = seed}).boxes) {
        if (box.name.starts_with("wall")) {
          all_m += box.size_m.y();
          plain_m += box.picture.find("wall_plain") != std::string::npos ? box.size_m.y() : 0;
        }
      }
    }
    return plain_m / all_m;
  };
  EXPECT_EQ(plain(0), 0);
  EXPECT_NEAR(plain(0.05), 0.05, 0.02);  // two sigma of 400 panels
  EXPECT_EQ(plain(1), 1);
}

TEST(GeneratedPlaces, ARoomWithoutASeedIsTheMissions) {
  auto settings = read_settings_text<WorldSettings>("generate: {room: {}}", "w.yaml", {});
  draw_place(settings, 9);
  EXPECT_EQ(description(expanded(settings)), description(made(RoomPlan{.seed = 9})));
  draw_place(settings, 10);  // it has one now
  EXPECT_EQ(description(expanded(settings)), description(made(RoomPlan{.seed = 9})));
}

TEST(GeneratedPlaces, LetARobotGetEverywhere) {
  constexpr double kRaster_m = 0.05;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    {
      SCOPED_TRACE("home");
      expect_one_piece(make_world(made(with_seed<HomePlan>(seed))), kRaster_m, 25);
    }
    {
      SCOPED_TRACE("corridors");
      expect_one_piece(make_world(made(with_seed<CorridorsPlan>(seed))), kRaster_m, 70);
    }
    {
      SCOPED_TRACE("warehouse");
      expect_one_piece(make_world(made(with_seed<WarehousePlan>(seed))), kRaster_m, 70);
    }
  }
}

TEST(GeneratedPlaces, LetARobotGoAroundTheBlock) {
  const World world = make_world(made(with_seed<StreetPlan>(3, {.length_m = 150})));
  const Obstacles obstacles(outlines(world, kFloorLayerTop_m, kRobotHeight_m));
  constexpr double kHouses_m = 1;  // behind their fronts, at the outer corners, is nothing
  EXPECT_EQ(places(cut_off(obstacles, 0.2, kHouses_m)), "");
  // The street is 8 m wide, 1.7 m of that are cars on one side.
  EXPECT_THAT(FreeRegion(obstacles, kHalfPassage_m).area_m2(), Gt(150 * 8 * 0.5));
}

TEST(GeneratedPlaces, OfOtherSizesHangTogetherToo) {
  constexpr double kRaster_m = 0.1;
  for (const int rooms : {1, 2, 3, 5, 6, 8}) {
    SCOPED_TRACE(fmt::format("{} rooms", rooms));
    expect_one_piece(make_world(made(HomePlan{.size_m = Vec2(16, 10), .rooms = rooms, .seed = 7})),
                     kRaster_m, 20);
  }
  for (const int loops : {1, 3, 4}) {
    SCOPED_TRACE(fmt::format("{} loops", loops));
    expect_one_piece(make_world(made(CorridorsPlan{
                         .size_m = Vec2(24, 18), .loops = loops, .width_m = 1.5, .seed = 7})),
                     kRaster_m, 50);
  }
  for (const int racks : {1, 3, 6}) {
    SCOPED_TRACE(fmt::format("{} racks", racks));
    expect_one_piece(
        make_world(made(WarehousePlan{.size_m = Vec2(24, 16), .racks = racks, .seed = 7})),
        kRaster_m, 100);
  }
}

TEST(GeneratedPlaces, AreLightEnoughToDraw) {
  constexpr std::size_t kIndoors = 45000;
  constexpr std::size_t kOutdoors = 60000;
  constexpr int kTexture_px = 512;
  for (const World& world : {make_world(made(HomePlan{})), make_world(made(CorridorsPlan{})),
                             make_world(made(WarehousePlan{}))}) {
    EXPECT_THAT(triangles_of(world), Le(kIndoors));
    for (const Texture& texture : world.textures) {
      EXPECT_THAT(std::max(texture.bgr.rows, texture.bgr.cols), Le(kTexture_px)) << texture.name;
    }
  }
  EXPECT_THAT(triangles_of(make_world(made(StreetPlan{}))), Le(kOutdoors));
}

TEST(GeneratedPlaces, HaveNamesThatEventsCanTell) {
  for (const WorldSettings& settings :
       {made(HomePlan{}), made(CorridorsPlan{}), made(WarehousePlan{}), made(StreetPlan{})}) {
    std::set<std::string> names;
    for (const BoxSettings& box : settings.boxes) {
      EXPECT_TRUE(names.insert(box.name).second) << box.name;
    }
    for (const ObjectSettings& object : settings.objects) {
      EXPECT_TRUE(names.insert(object.name).second) << object.name;
    }
  }
}

TEST(GeneratedPlaces, HomesHaveDoorsAndChairsThatMove) {
  int doors = 0;
  int chairs = 0;
  for (const ObjectSettings& object : made(HomePlan{}).objects) {
    doors += object.movable && object.mesh.find("door") != std::string::npos ? 1 : 0;
    chairs += object.movable && object.mesh.find("chair") != std::string::npos ? 1 : 0;
  }
  EXPECT_THAT(doors, Gt(0));
  EXPECT_THAT(chairs, Gt(0));
}

TEST(GeneratedPlaces, TheStreetLiesUnderASkyThatChanges) {
  const WorldSettings street = made(StreetPlan{});
  ASSERT_TRUE(street.sun.has_value());
  EXPECT_EQ(street.sun->group, "daylight");
  EXPECT_EQ(street.ambient_group, "daylight");
  EXPECT_THAT(street.sky_bgr.minCoeff(), Gt(0));
  EXPECT_THAT(street.events, Not(IsEmpty()));
  for (const EventSettings& event : street.events) {
    EXPECT_EQ(event.lights, "daylight");
  }
}

template <class Plan>
std::string refusal(const Plan& plan) {
  WorldSettings into;
  try {
    generate(plan, into);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(GeneratedPlaces, RefusePlansThatDoNotFit) {
  EXPECT_EQ(refusal(HomePlan{.size_m = Vec2(6, 9)}),
            "home.size_m: must be at most 40 m each way and leave every room 3 m: for 4 rooms "
            "beside a hall of 1.6 m at "
            "least [6.12, 7.84]");
  EXPECT_EQ(refusal(HomePlan{.rooms = 0}), "home.rooms: must be between 1 and 8");
  EXPECT_EQ(refusal(CorridorsPlan{.size_m = Vec2(8, 8)}),
            "corridors.size_m: must be at most 80 m each way and hold 2 x 1 blocks of 2.4 m with "
            "corridors of 1.8 m around "
            "them: at least [10.2, 6]");
  EXPECT_THAT(refusal(CorridorsPlan{.loops = 0}), HasSubstr("loops must be between 1 and 12"));
  EXPECT_EQ(refusal(WarehousePlan{.size_m = Vec2(18, 9)}),
            "warehouse.size_m: must be at most 80 m each way and hold 4 racks with aisles of 1.9 "
            "m: at least [7.1, 10.14]");
  EXPECT_EQ(refusal(WarehousePlan{.racks = 0}), "warehouse.racks: must be between 1 and 20");
  EXPECT_EQ(refusal(RoomPlan{.size_m = Vec2(3, 5)}),
            "room.size_m: must be between 3.5 m and 12 m each way");
  EXPECT_EQ(refusal(StreetPlan{.length_m = 20}), "street.length_m: must be between 100 and 1000 m");
}

}  // namespace
}  // namespace panoptes::sim

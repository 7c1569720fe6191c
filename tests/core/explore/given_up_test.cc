// SPDX-License-Identifier: BSD-3-Clause
#include "core/explore/given_up.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/support/floor_plan.h"

namespace panoptes {
namespace {

constexpr double kFor_s = 30;
const Pose2 kPlace{3, 2, 0.3};

GivenUp::Known known(const OccupancyMap& map) {
  return [map](const Vec2& p) { return map.at(p); };
}

/// A room with a box in it whose near side is at this x.
OccupancyMap room_with_box(double x_m) {
  OccupancyMap map = test::empty_room(6, 4, 0.05);
  test::fill(map, x_m, 1.6, x_m + 0.5, 2.4, Cell::kOccupied);
  return map;
}

TEST(GivenUp, ComesBackOnlyWhenTheMapHasChangedAndNotBeforeItsTime) {
  GivenUp given_up(0.3, kFor_s);
  given_up.add(time_at(0), kPlace, known(room_with_box(3.2)), {});
  const auto away = [&](double at_s, double box_x_m) {
    given_up.update(time_at(at_s), known(room_with_box(box_x_m)), {});
    return given_up.contains(kPlace.position() + Vec2(0.2, 0));
  };
  EXPECT_TRUE(away(kFor_s - 1, 5)) << "the box has gone, but it is too early";
  EXPECT_TRUE(away(1000 * kFor_s, 3.2)) << "late, but all is as it was";
  EXPECT_FALSE(away(1000 * kFor_s + 1, 5));
  EXPECT_FALSE(given_up.contains(kPlace.position() + Vec2(0.4, 0)));
}

TEST(GivenUp, AnEdgeThatMovesByACellIsTheSameEdge) {
  GivenUp given_up(0.3, kFor_s);
  given_up.add(time_at(0), kPlace, known(room_with_box(3.2)), {});
  for (const double x_m : {3.15, 3.25}) {
    given_up.update(time_at(2 * kFor_s), known(room_with_box(x_m)), {});
    EXPECT_TRUE(given_up.contains(kPlace.position())) << x_m;
  }
}

TEST(GivenUp, IsLeftAloneTwiceAsLongEachTime) {
  GivenUp given_up(0.3, kFor_s);
  double at_s = 0;
  for (const double for_s : {kFor_s, 2 * kFor_s, 4 * kFor_s}) {
    given_up.add(time_at(at_s), kPlace, known(room_with_box(3.2)), {});
    given_up.update(time_at(at_s + for_s - 1), known(room_with_box(5)), {});
    EXPECT_TRUE(given_up.contains(kPlace.position())) << for_s;
    at_s += for_s;
    given_up.update(time_at(at_s), known(room_with_box(5)), {});
    EXPECT_FALSE(given_up.contains(kPlace.position())) << for_s;
    EXPECT_TRUE(given_up.places_map().empty());
  }
}

TEST(GivenUp, IsReopenedBeforeItsTimeWhereTheMapHasChanged) {
  GivenUp given_up(0.3, kFor_s);
  given_up.add(time_at(0), kPlace, known(room_with_box(3.2)), {});
  given_up.reopen_changed(known(room_with_box(3.2)));
  EXPECT_TRUE(given_up.contains(kPlace.position()));
  given_up.reopen_changed(known(room_with_box(5)));
  EXPECT_FALSE(given_up.contains(kPlace.position()));
}

TEST(GivenUp, IsTriedOnceMoreAsThingsAre) {
  GivenUp given_up(0.3, kFor_s);
  EXPECT_FALSE(given_up.try_again());
  given_up.add(time_at(0), kPlace, known(room_with_box(3.2)), {});
  EXPECT_TRUE(given_up.try_again());
  EXPECT_FALSE(given_up.contains(kPlace.position()));
  given_up.add(time_at(10), kPlace, known(room_with_box(3.2)), {});
  EXPECT_FALSE(given_up.try_again()) << "given up twice";
  EXPECT_TRUE(given_up.contains(kPlace.position()));
}

TEST(GivenUp, GoesWhereItsKeyframeGoes) {
  std::vector<Pose2> T_map_keyframes = {{2, 2, 0}};
  GivenUp given_up(0.3, kFor_s);
  given_up.add(time_at(0), kPlace, known(room_with_box(3.2)), T_map_keyframes);
  T_map_keyframes[0].y_m += 1;
  given_up.update(time_at(1), known(room_with_box(3.2)), T_map_keyframes);
  EXPECT_FALSE(given_up.contains(kPlace.position()));
  EXPECT_TRUE(given_up.contains(kPlace.position() + Vec2(0, 1)));
}

}  // namespace
}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/newcomers.h"

#include <algorithm>
#include <memory>
#include <optional>

#include <gtest/gtest.h>

#include "tests/support/floor_scene.h"

namespace panoptes {
namespace {

constexpr double kFrame_s = 1.0 / 15;

/// A robot at the origin that looks along x, on floor that is known to be free.
struct Watch {
  std::shared_ptr<const FloorProjection> projection =
      std::make_shared<FloorProjection>(project_floor(office_floor_camera(), Body{}));
  OccupancyMap known;
  Newcomers newcomers;
  double now_s = 0;
  double frame_s = kFrame_s;

  Watch() {
    known.cell_m = 0.02;
    known.origin = Vec2(-3, -3);
    known.assign(300, 300);
    std::fill(known.cells.begin(), known.cells.end(), Cell::kFree);
  }

  /// Pictures in which something stands on a square of 12 cm here; none: only floor.
  void look(const std::optional<Vec2>& at, int pictures, const Pose2& T_odom_body = {}) {
    for (int k = 0; k < pictures; ++k) {
      FloorReading reading;
      reading.projection = projection;
      for (int row = 0; row < projection->cell_rows; ++row) {
        for (int column = 0; column < projection->cell_columns; ++column) {
          const Vec2 p = T_odom_body * (projection->origin_view +
                                        projection->cell_m * Vec2(column + 0.5, row + 0.5));
          const bool seen = projection->sample[reading.evidence.size()] >= 0;
          const bool stands = at && (p - *at).cwiseAbs().maxCoeff() < 0.06;
          reading.evidence.push_back(static_cast<std::int8_t>(!seen ? 0 : stands ? -20 : 20));
        }
      }
      newcomers.add(reading, T_odom_body, known, time_at(now_s));
      now_s += frame_s;
    }
  }

  double nearest_m(const Vec2& to) const {
    double nearest = 1e9;
    for (const Vec2& p : newcomers.places_odom()) {
      nearest = std::min(nearest, (p - to).norm());
    }
    return nearest;
  }
};

TEST(Newcomers, WhoStandsOnKnownFloorIsThereAfterThreePicturesAndGoneAfterTwo) {
  Watch watch;
  watch.look(Vec2(1.2, 0.1), 2);
  EXPECT_TRUE(watch.newcomers.places_odom().empty());
  EXPECT_FALSE(watch.newcomers.ever());
  watch.look(Vec2(1.2, 0.1), 1);
  EXPECT_LT(watch.nearest_m(Vec2(1.2, 0.1)), 0.05);
  watch.look(std::nullopt, 1);
  EXPECT_LT(watch.nearest_m(Vec2(1.2, 0.1)), 0.05);
  EXPECT_TRUE(watch.newcomers.left_odom().empty());
  watch.look(std::nullopt, 1);
  EXPECT_TRUE(watch.newcomers.places_odom().empty());
  EXPECT_FALSE(watch.newcomers.left_odom().empty());
  for (const Vec2& p : watch.newcomers.left_odom()) {
    EXPECT_LT((p - Vec2(1.2, 0.1)).norm(), 0.15);
  }
  watch.look(std::nullopt, 1);
  EXPECT_TRUE(watch.newcomers.left_odom().empty());
}

TEST(Newcomers, WhoWalksIsFollowed) {
  Watch watch;
  Vec2 at(1.3, -0.5);
  for (int k = 0; k < 12; ++k) {  // at 1.1 m/s
    at.y() += 1.1 * kFrame_s;
    watch.look(at, 1);
    if (k >= 3) {
      EXPECT_LT(watch.nearest_m(at), 0.07) << k;
    }
  }
  EXPECT_GT(watch.nearest_m(Vec2(1.3, -0.4)), 0.3) << "where he was";
}

TEST(Newcomers, WhatWasKnownToStandIsNone) {
  Watch watch;
  for (int row = 0; row < watch.known.rows; ++row) {
    for (int column = 0; column < watch.known.columns; ++column) {
      if ((watch.known.centre(column, row) - Vec2(1.2, 0.1)).cwiseAbs().maxCoeff() < 0.05) {
        watch.known(column, row) = Cell::kOccupied;
      }
    }
  }
  watch.look(Vec2(1.2, 0.1), 10);
  EXPECT_TRUE(watch.newcomers.places_odom().empty());
}

TEST(Newcomers, AFlickerAndWhatIsFarAwayAreNone) {
  Watch watch;
  for (int k = 0; k < 10; ++k) {
    watch.look(Vec2(1.2, 0.1), 1);
    watch.look(std::nullopt, 2);
    EXPECT_TRUE(watch.newcomers.places_odom().empty()) << k;
  }
  watch.look(Vec2(2.5, 0.1), 10);
  EXPECT_TRUE(watch.newcomers.places_odom().empty());
}

TEST(Newcomers, OutOfViewTheyAreKeptForAWhile) {
  Watch watch;
  watch.look(Vec2(1.2, 0.1), 3);
  const Pose2 turned{0, 0, 3};
  watch.frame_s = 0.5;
  watch.look(std::nullopt, 18, turned);
  EXPECT_LT(watch.nearest_m(Vec2(1.2, 0.1)), 0.05);
  watch.look(std::nullopt, 5, turned);
  EXPECT_TRUE(watch.newcomers.places_odom().empty());
}

TEST(Newcomers, WhatStaysIsNoNewcomer) {
  Watch watch;
  watch.frame_s = 0.5;
  watch.look(Vec2(1.2, 0.1), 2 * 59);
  EXPECT_FALSE(watch.newcomers.places_odom().empty());
  EXPECT_TRUE(watch.newcomers.ever());
  std::fill(watch.known.cells.begin(), watch.known.cells.end(), Cell::kOccupied);
  watch.look(Vec2(1.2, 0.1), 2 * 3);
  EXPECT_TRUE(watch.newcomers.places_odom().empty());
}

TEST(Newcomers, AreWiderThanWhatIsSeenOfThem) {
  Watch watch;
  watch.look(Vec2(1.2, 0.1), 3);
  OccupancyMap local = watch.known;
  watch.newcomers.occupy(local);
  EXPECT_EQ(local.at(Vec2(1.04, 0.1)), Cell::kOccupied);
  EXPECT_EQ(local.at(Vec2(1.2, 0.26)), Cell::kOccupied);
  EXPECT_EQ(local.at(Vec2(0.9, 0.1)), Cell::kFree);
}

}  // namespace
}  // namespace panoptes

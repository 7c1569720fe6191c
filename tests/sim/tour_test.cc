// SPDX-License-Identifier: BSD-3-Clause
#include "sim/tour.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/eval/loops.h"

namespace panoptes::sim {
namespace {

constexpr double kAisle_m = 1.0;
const Vec2 kStart(0.5, 0.5);

// A closed hall of 9 m x 7 m on cells of 5 cm with a two-by-two of blocks: aisles between and
// around them, and a dead end.
TruthLayer hall() {
  TruthLayer layer;
  layer.cell_m = 0.05;
  layer.origin = Vec2(-0.1, -0.1);
  layer.columns = 184;
  layer.rows = 144;
  layer.cells.assign(static_cast<std::size_t>(layer.columns) * layer.rows, 0);
  for (int row = 0; row < layer.rows; ++row) {
    for (int column = 0; column < layer.columns; ++column) {
      const Vec2 p = layer.origin + layer.cell_m * Vec2(column + 0.5, row + 0.5);
      const auto inside = [&](double x0, double y0, double x1, double y1) {
        return p.x() > x0 && p.x() < x1 && p.y() > y0 && p.y() < y1;
      };
      const bool wall = !inside(0, 0, 9, 7);
      const bool block = inside(1, 1, 4, 3) || inside(5, 1, 8, 3) || inside(1, 4, 4, 6) ||
                         inside(5, 4, 8, 6) || inside(8, 4, 8.1, 7);
      layer.cells[static_cast<std::size_t>(row) * layer.columns + column] = wall || block ? 1 : 0;
    }
  }
  return layer;
}

// Poses a hand's breadth apart along the way, as a robot that turns at its corners has them.
std::vector<Pose2> driven(const std::vector<Waypoint>& waypoints) {
  std::vector<Pose2> poses;
  Vec2 at = kStart;
  for (const Waypoint& waypoint : waypoints) {
    const Vec2 step = Vec2(waypoint.x_m, waypoint.y_m) - at;
    const int count = std::max(1, static_cast<int>(step.norm() / 0.1));
    for (int i = 1; i <= count; ++i) {
      const Vec2 p = at + step * (static_cast<double>(i) / count);
      poses.push_back({p.x(), p.y(), std::atan2(step.y(), step.x())});
    }
    at += step;
  }
  return poses;
}

int passes(const std::vector<Pose2>& poses, const Vec2& place, double theta_rad) {
  return static_cast<int>(std::count_if(poses.begin(), poses.end(), [&](const Pose2& pose) {
    return (pose.position() - place).norm() < kAisle_m / 2 &&
           std::abs(wrap_angle(pose.theta_rad - theta_rad)) < deg_to_rad(30);
  }));
}

TEST(Tour, TakesEveryAisleInBothDirectionsAndTouchesNothing) {
  const TruthLayer layer = hall();
  const Body body;
  TourOptions options;
  options.length_m = 300;
  const std::vector<Pose2> poses = driven(tour(options, layer, body, kStart));
  EXPECT_GE(path_lengths_m(poses).back(), options.length_m - 1);
  for (const Pose2& pose : poses) {
    for (double angle = 0; angle < 6.3; angle += 0.3) {
      EXPECT_FALSE(
          layer.at(pose.position() + body.radius_m * Vec2(std::cos(angle), std::sin(angle))));
    }
  }
  struct Aisle {
    Vec2 middle;
    double theta_deg;
  };
  const std::vector<Aisle> aisles{{{2.5, 0.5}, 0}, {{6.5, 0.5}, 0}, {{2.5, 3.5}, 0},
                                  {{6.5, 3.5}, 0}, {{2.5, 6.5}, 0}, {{6.5, 6.5}, 0},
                                  {{0.5, 2}, 90},  {{0.5, 5}, 90},  {{4.5, 2}, 90},
                                  {{4.5, 5}, 90},  {{8.5, 2}, 90},  {{8.6, 5.5}, 90}};
  for (const Aisle& aisle : aisles) {
    for (const double there_deg : {0.0, 180.0}) {
      EXPECT_GT(passes(poses, aisle.middle, deg_to_rad(aisle.theta_deg + there_deg)), 0)
          << aisle.middle.transpose() << ", " << aisle.theta_deg + there_deg;
    }
  }
}

TEST(Tour, ComesBackOftenBothWays) {
  const std::vector<Pose2> poses = driven(tour(TourOptions{}, hall(), Body{}, kStart));
  int same = 0;
  int opposite = 0;
  for (const TrueRevisit& revisit : revisits(poses, path_lengths_m(poses))) {
    ++(revisit.heading == Heading::kSame ? same : opposite);
  }
  EXPECT_GE(same, 10);
  EXPECT_GE(opposite, 10);
}

TEST(Tour, NeedsSomewhereToGo) {
  TourOptions options;
  options.apart_m = 50;
  EXPECT_THROW(tour(options, hall(), Body{}, kStart), ConfigError);
}

}  // namespace
}  // namespace panoptes::sim

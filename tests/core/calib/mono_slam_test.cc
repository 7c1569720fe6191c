// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/mono_slam.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "core/calib/mono_map.h"
#include "core/camera/mounting.h"
#include "tests/support/room_pictures.h"

namespace panoptes {
namespace {

const Intrinsics kLens = lens_of_view(320, 240, deg_to_rad(80), BrownConrady{-0.2, 0.03, 0, 0, 0});

/// 0.4 m to the right and back, then a quarter of a turn to the right about an axis 0.15 m behind.
Pose3 driven(double t_s) {
  const double out_m = t_s < 4 ? 0.2 * (1 - std::cos(t_s / 2 * std::numbers::pi)) : 0;
  const double turn_rad = t_s < 4
                              ? 0
                              : (1 - std::cos(std::min(1.0, (t_s - 4) / 4) * std::numbers::pi)) /
                                    2 * std::numbers::pi / 2;
  const Eigen::Quaterniond turn = turned_by(Vec3(0, turn_rad, 0));
  return {turn, turn * Vec3(0, 0, 0.15) + Vec3(out_m, 0.1, 0)};
}

struct Driven {
  MonoMap map;
  std::vector<Pose3> true_map;
};

/// `shown` may change what a picture shows, by its number.
template <class Shown>
Driven run(double contrast, double duration_s, const Shown& shown) {
  Rng rng(3);
  const RoomPainter room(kLens, contrast, rng.fork("room"));
  Rng noise = rng.fork("noise");
  MonoSlam slam({}, kLens);
  MonoMapBuilder builder;
  Driven out;
  for (int i = 0; i / 15.0 < duration_s; ++i) {
    cv::Mat picture = room.draw(driven(i / 15.0), noise);
    shown(i, picture);
    builder.add(time_at(i / 15.0), slam.step(picture, time_at(i / 15.0)));
    out.true_map.push_back(driven(0).inverse() * driven(i / 15.0));
  }
  out.map = builder.map(slam);
  return out;
}

const auto kAsItIs = [](int, cv::Mat&) {};

double heading_error_deg(const Driven& r) {
  const Pose3& believed = r.map.frames.back().T_map_camera;
  return rad_to_deg(believed.rotation.angularDistance(r.true_map.back().rotation));
}

TEST(MonoSlam, MapsAQuarterOfARoom) {
  const Driven r = run(120, 8.5, kAsItIs);
  EXPECT_LT(heading_error_deg(r), 0.3);  // half a pixel
  EXPECT_GT(r.map.points.size(), 30U);
  EXPECT_EQ(r.map.lost_s, 0);
  EXPECT_FALSE(r.map.closed);
  EXPECT_LT(r.map.normalised_innovation, 2);
  // Shape: with the scale that the farthest point of the drive has, where every point lies on a
  // wall.
  std::vector<double> off_m;
  const double scale =
      0.4 / r.map.frames[30].T_map_camera.translation.norm();  // truly 0.4 m from the start
  for (const MonoMap::Point& point : r.map.points) {
    const Vec3 p_room = driven(0) * Vec3(scale * point.p_map);
    const double to_wall_m =
        std::min({std::abs(std::abs(p_room.x()) - 3), std::abs(std::abs(p_room.y()) - 1.3),
                  std::abs(std::abs(p_room.z()) - 3)});
    off_m.push_back(to_wall_m);
  }
  std::sort(off_m.begin(), off_m.end());
  constexpr double kDepth_m = 0.1;  // a thirtieth of how far the walls are, after 0.4 m of drive
  EXPECT_LT(off_m[off_m.size() / 2], kDepth_m);
}

TEST(MonoSlam, IsTheSameEveryTime) {
  const Driven a = run(120, 1, kAsItIs);
  const Driven b = run(120, 1, kAsItIs);
  EXPECT_EQ(a.map.frames.back().T_map_camera.translation,
            b.map.frames.back().T_map_camera.translation);
  ASSERT_EQ(a.map.points.size(), b.map.points.size());
}

TEST(MonoSlam, ARoomWithNothingToSeeGivesNoMap) {
  const Driven r = run(0, 1, kAsItIs);
  EXPECT_TRUE(r.map.points.empty());
}

TEST(MonoSlam, IsLostWhileTheLensIsCoveredAndFoundAgain) {
  const Driven r = run(120, 5.5, [](int i, cv::Mat& picture) {
    if (i >= 60 && i < 70) {
      picture.setTo(20);
    }
  });
  EXPECT_FALSE(r.map.frames[59].lost);
  EXPECT_TRUE(r.map.frames[61].lost);
  EXPECT_FALSE(r.map.frames.back().lost);
  EXPECT_GT(r.map.lost_s, 0.6);
  EXPECT_LT(heading_error_deg(r), 0.5);
}

// A lens that stays covered leaves the camera nowhere: it must not map on from where it guesses to
// be.
TEST(MonoSlam, WhoIsLostForLongMapsNothing) {
  std::size_t points = 0;
  Rng rng(3);
  const RoomPainter room(kLens, 120, rng.fork("room"));
  Rng noise = rng.fork("noise");
  MonoSlam slam({}, kLens);
  MonoSlamStep step;
  for (int i = 0; i < 8 * 15; ++i) {
    cv::Mat picture = room.draw(driven(i / 15.0), noise);
    if (i >= 5 * 15 && i < 7 * 15) {  // in the middle of its turn
      picture.setTo(20);
    }
    step = slam.step(picture, time_at(i / 15.0));
    if (i == 5 * 15) {
      points = slam.points().size();
    }
    if (step.lost) {
      EXPECT_TRUE(step.added.empty());
    }
  }
  EXPECT_TRUE(step.lost || slam.points().size() > points / 2);
  // Wherever it says that it is not lost it is where it says.
  const Pose3 T_true = driven(0).inverse() * driven((8 * 15 - 1) / 15.0);
  if (!step.lost) {
    EXPECT_LT(rad_to_deg(step.T_map_camera.rotation.angularDistance(T_true.rotation)), 1);
  }
}

// Pictures of another room all at once: none of its points are taken for those of the map.
TEST(MonoSlam, AJumpInThePicturesIsTold) {
  Rng rng(3);
  const RoomPainter room(kLens, 120, rng.fork("room"));
  const RoomPainter other(kLens, 120, rng.fork("other"));
  Rng noise = rng.fork("noise");
  MonoSlam slam({}, kLens);
  for (int i = 0; i < 5 * 15; ++i) {
    const bool jumped = i >= 4 * 15;
    const MonoSlamStep step =
        slam.step((jumped ? other : room).draw(driven(i / 15.0), noise), time_at(i / 15.0));
    EXPECT_EQ(step.lost, jumped) << i;
  }
}

/// The whole drive, its motion told. `draw` makes a picture by its number; `see` is shown each
/// step.
template <class Draw, class See>
Pose3 run_told(const Draw& draw, const See& see) {
  MonoSlamOptions options;
  options.motion_is_told = true;
  MonoSlam slam(options, kLens);
  const Eigen::Matrix<double, 6, 1> sigma = Eigen::Matrix<double, 6, 1>::Constant(0.002);
  Pose3 before = driven(0);
  MonoSlamStep step;
  for (int i = 0; i <= 120; ++i) {
    const Pose3 here = driven(i / 15.0);
    std::optional<MotionTold> told;
    if (i > 0) {
      told = MotionTold{before.inverse() * here, sigma.cwiseAbs2().asDiagonal()};
    }
    step = slam.step(draw(i, here), time_at(i / 15.0), told);
    before = here;
    EXPECT_FALSE(step.begins_anew);
    see(i, step);
  }
  return step.T_map_camera;
}

void expect_end(const Pose3& T_map_camera) {
  const Pose3 T_true = driven(0).inverse() * driven(8);
  EXPECT_LT(rad_to_deg(T_map_camera.rotation.angularDistance(T_true.rotation)), 0.5);
  EXPECT_LT((T_map_camera.translation - T_true.translation).norm(), 0.02);
}

/// Without five pictures, while its turn begins. How long it is lost then, and by how much its
/// heading is off at the end.
std::pair<double, double> over_a_gap(bool is_told) {
  Rng rng(3);
  const RoomPainter room(kLens, 120, rng.fork("room"));
  Rng noise = rng.fork("noise");
  MonoSlam slam({}, kLens);
  double lost_s = 0;
  std::optional<Pose3> before;
  for (int i = 0; i < 120; ++i) {
    if (i > 68 && i < 74) {
      continue;
    }
    const Pose3 here = driven(i / 15.0);
    std::optional<MotionTold> told;
    if (is_told && i == 74) {  // in another metre than the map's
      const Pose3 moved = before->inverse() * here;
      Eigen::Matrix<double, 6, 1> sigma;
      sigma << Vec3::Constant(0.01), Vec3::Constant(0.01);
      told = MotionTold{{moved.rotation, 7 * moved.translation}, sigma.cwiseAbs2().asDiagonal()};
    }
    const MonoSlamStep step = slam.step(room.draw(here, noise), time_at(i / 15.0), told);
    lost_s += i >= 74 && step.lost ? 1 / 15.0 : 0;
    before = here;
  }
  const Pose3 truly = driven(0).inverse() * driven(119 / 15.0);
  return {lost_s, slam.filter().T_map_camera().rotation.angularDistance(truly.rotation)};
}

TEST(MonoSlam, AToldTurnLeadsOverAGapBetweenPictures) {
  const auto [alone_s, alone_rad] = over_a_gap(false);
  EXPECT_GT(alone_s, 0);
  const auto [told_s, told_rad] = over_a_gap(true);
  EXPECT_EQ(told_s, 0);
  EXPECT_LT(told_rad, deg_to_rad(1));
}

// Then the metre of the map is a metre.
TEST(MonoSlam, TakesTheMotionThatIsTold) {
  Rng rng(3);
  const RoomPainter room(kLens, 120, rng.fork("room"));
  Rng noise = rng.fork("noise");
  expect_end(run_told([&](int, const Pose3& here) { return room.draw(here, noise); },
                      [](int i, const MonoSlamStep& step) { EXPECT_FALSE(step.lost) << i; }));
}

// While its lens is covered it turns to where it has mapped nothing yet, and maps on there.
TEST(MonoSlam, ToldMotionLeadsACameraThatSeesNothing) {
  Rng rng(3);
  const RoomPainter room(kLens, 120, rng.fork("room"));
  Rng noise = rng.fork("noise");
  int mapped = 0;
  expect_end(run_told(
      [&](int i, const Pose3& here) {
        cv::Mat picture = room.draw(here, noise);
        if (i >= 75 && i < 108) {
          picture.setTo(20);
        }
        return picture;
      },
      [&](int i, const MonoSlamStep& step) {
        EXPECT_FALSE(step.lost) << i;
        mapped += i >= 108 ? static_cast<int>(step.added.size()) : 0;
      }));
  EXPECT_GT(mapped, 8);
}

// It was carried into another room: what its wheels tell leads it no more.
TEST(MonoSlam, WhoDoesNotSeeWhatItOughtToIsLostThoughItsMotionIsTold) {
  Rng rng(3);
  const RoomPainter room(kLens, 120, rng.fork("room"));
  const RoomPainter other(kLens, 120, rng.fork("other"));
  Rng noise = rng.fork("noise");
  run_told([&](int i, const Pose3& here) { return (i < 60 ? room : other).draw(here, noise); },
           [](int i, const MonoSlamStep& step) { EXPECT_EQ(step.lost, i >= 60) << i; });
}

}  // namespace
}  // namespace panoptes

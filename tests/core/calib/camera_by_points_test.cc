// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/camera_by_points.h"

#include <algorithm>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "core/camera/mounting.h"
#include "tests/support/room_pictures.h"

namespace panoptes {
namespace {

const Intrinsics kLens = lens_of_view(640, 480, deg_to_rad(80), BrownConrady{-0.2, 0.03, 0, 0, 0});
constexpr FeatureMethod kMethod = FeatureMethod::kSift;

/// Where a ray from within the room of RoomPainter ends.
Vec3 on_wall(const Vec3& from, const Vec3& ray) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double wall = axis == 1 ? 1.3 : 3;
    nearest = std::min(nearest, ((ray[axis] > 0 ? wall : -wall) - from[axis]) / ray[axis]);
  }
  return from + nearest * ray;
}

struct Known {
  RoomPainter room{kLens, 120, Rng(3)};
  Rng noise{4};
  Pose3 T_room_camera{turned_by(Vec3(0, 0.2, 0)), Vec3(0.2, 0.1, -0.5)};
  std::vector<KnownPoint> points;

  /// Every so many-th of what one picture shows.
  explicit Known(std::size_t every) {
    const cv::Mat picture = room.draw(T_room_camera, noise);
    const std::vector<SalientFeature> features =
        salient_features(kMethod, picture, cv::Rect(30, 30, 580, 420));
    for (std::size_t i = 0; i < std::min<std::size_t>(300, features.size()); i += every) {
      const Vec3 ray = T_room_camera.rotation * kLens.direction(features[i].px).value();
      const cv::Mat descriptor = describe(kMethod, picture, features[i]);
      if (!descriptor.empty()) {
        points.push_back({on_wall(T_room_camera.translation, ray), descriptor});
      }
    }
  }
};

TEST(CameraByPoints, IsFoundAmongMuchThatIsNotKnown) {
  Known known(8);
  ASSERT_LT(known.points.size(), 40U);
  const Pose3 T_true{turned_by(Vec3(0.02, 0.35, 0)), Vec3(0.5, 0.05, -0.2)};
  const auto found =
      camera_by_points(kMethod, kLens, known.room.draw(T_true, known.noise), known.points);
  ASSERT_TRUE(found);
  EXPECT_LT(rad_to_deg(found->rotation.angularDistance(T_true.rotation)), 1);
  EXPECT_LT((found->translation - T_true.translation).norm(), 0.06);
}

TEST(CameraByPoints, IsNotFoundWhereNothingIsKnown) {
  Known known(2);
  const Pose3 T_back{turned_by(Vec3(0, 3, 0)), Vec3(0.2, 0.1, 0)};
  EXPECT_FALSE(
      camera_by_points(kMethod, kLens, known.room.draw(T_back, known.noise), known.points));
  EXPECT_FALSE(camera_by_points(kMethod, kLens, cv::Mat(480, 640, CV_8U, 100), known.points));
  EXPECT_FALSE(camera_by_points(kMethod, kLens, known.room.draw(T_back, known.noise), {}));
}

}  // namespace
}  // namespace panoptes

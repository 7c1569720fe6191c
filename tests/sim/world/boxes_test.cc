// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/boxes.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "sim/world/layers.h"
#include "tests/support/scratch.h"

namespace panoptes::sim {
namespace {

constexpr double kRoundoff_m = 1e-12;

class Boxes : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    cv::imwrite(path("a.png"), cv::Mat(4, 4, CV_8UC3, cv::Scalar(10, 20, 30)));
    cv::imwrite(path("b.png"), cv::Mat(4, 4, CV_8UC3, cv::Scalar(90, 80, 70)));
  }

  static World make(const BoxSettings& box) {
    WorldSettings settings;
    settings.boxes = {box};
    return make_world(settings);
  }
  BoxSettings shelf() const {
    BoxSettings box;
    box.name = "shelf";
    box.size_m = {0.8, 0.3, 2};
    box.at = {1, 2, 0.5};
    box.z_m = 0.1;
    box.picture = path("a.png");
    return box;
  }
};

Vec3 normal_of(const Triangle& t) {
  return (t.corners[1].p_object - t.corners[0].p_object)
      .cross(t.corners[2].p_object - t.corners[0].p_object)
      .normalized();
}

TEST_F(Boxes, HaveTheirFacesOutwardsAndFillTheirSize) {
  const World world = make(shelf());
  ASSERT_EQ(world.objects.size(), 1U);
  double six_volumes_m3 = 0;
  for (const Triangle& t : world.objects[0].triangles) {
    six_volumes_m3 += t.corners[0].p_object.dot(t.corners[1].p_object.cross(t.corners[2].p_object));
  }
  EXPECT_NEAR(six_volumes_m3 / 6, 0.8 * 0.3 * 2, kRoundoff_m);
  EXPECT_EQ(world.objects[0].triangles.size(), 12U);
  EXPECT_TRUE(outlines(world, 0.02, 0.1).empty());
  const std::vector<Outline> found = outlines(world, 0.02, 0.2);
  ASSERT_EQ(found.size(), 1U);
  const Vec2 corner = Pose2{1, 2, 0.5} * Vec2(0.4, 0.15);
  EXPECT_TRUE(std::any_of(found[0].corners_scene.begin(), found[0].corners_scene.end(),
                          [&](const Vec2& p) { return (p - corner).norm() < kRoundoff_m; }));
}

TEST_F(Boxes, ShowEachPictureUprightFromOutside) {
  for (const Triangle& t : make(shelf()).objects[0].triangles) {
    const Vec3 normal = normal_of(t);
    const Vec3 up = std::abs(normal.z()) < 0.5 ? Vec3(Vec3::UnitZ()) : Vec3(Vec3::UnitY());
    const Vec3 right = up.cross(normal);
    for (const Corner& corner : t.corners) {
      const Vec3 p = corner.p_object - Vec3(0, 0, 1);
      EXPECT_EQ(corner.uv.x(), p.dot(right) > 0 ? 1 : 0);
      EXPECT_EQ(corner.uv.y(), p.dot(up) > 0 ? 0 : 1);
    }
  }
}

TEST_F(Boxes, RepeatAPictureOfAGivenSizeFromTheTopLeft) {
  BoxSettings box = shelf();
  box.picture_m = {0.4, 0.5};
  for (const Triangle& t : make(box).objects[0].triangles) {
    const Vec3 normal = normal_of(t);
    for (const Corner& corner : t.corners) {
      if (std::abs(normal.z()) < 0.5) {
        EXPECT_NEAR(corner.uv.y(), (2 - corner.p_object.z()) / 0.5, kRoundoff_m);
      }
      if (normal.y() < -0.5) {  // seen from -y, x runs to the right
        EXPECT_NEAR(corner.uv.x(), (corner.p_object.x() + 0.4) / 0.4, kRoundoff_m);
      }
    }
  }
}

TEST_F(Boxes, FacesMayHaveOtherPicturesOrNone) {
  BoxSettings box = shelf();
  box.faces = {{"front", path("b.png")}, {"back", ""}, {"top", ""}};
  const World world = make(box);
  EXPECT_EQ(world.objects[0].triangles.size(), 8U);
  for (const Triangle& t : world.objects[0].triangles) {
    const bool is_front = normal_of(t).x() > 0.5;
    EXPECT_EQ(world.textures[static_cast<std::size_t>(t.texture)].name,
              path(is_front ? "b.png" : "a.png"));
    EXPECT_GT(normal_of(t).x(), -0.5);
  }
  // It is as solid as before.
  EXPECT_EQ(occupancy(world, 0.02, 1, 0.05).cells, occupancy(make(shelf()), 0.02, 1, 0.05).cells);
}

TEST_F(Boxes, AnUndersideOnTheFloorIsLeftOut) {
  BoxSettings box = shelf();
  box.z_m = 0;
  EXPECT_EQ(make(box).objects[0].triangles.size(), 10U);
  box.faces = {{"bottom", path("b.png")}};
  EXPECT_EQ(make(box).objects[0].triangles.size(), 12U);
}

TEST_F(Boxes, ADoorTurnsAboutItsHinge) {
  BoxSettings door;
  door.name = "door";
  door.size_m = {0.9, 0.04, 2};
  door.at = {3, 1, 0};
  door.hinge_m = {-0.45, 0};
  door.movable = true;
  EventSettings opens;
  opens.at_s = 2;
  opens.over_s = 1;
  opens.open = "door";
  opens.angle_rad = deg_to_rad(90);
  WorldSettings settings;
  settings.boxes = {door};
  settings.events = {opens};
  const World world = make_world(settings);
  const TruthLayer shut = occupancy(world, 0.02, 1, 0.01);
  EXPECT_TRUE(shut.at({3.85, 1}));
  EXPECT_FALSE(shut.at({2.9, 1}));
  ASSERT_EQ(world.move_events.size(), 1U);
  const MoveEvent& event = world.move_events[0];
  EXPECT_EQ(event.at, time_at(2));
  EXPECT_EQ(event.over, from_seconds(1));
  EXPECT_EQ(event.object, 0U);
  const Pose2& open = event.T_scene_object;
  EXPECT_LT((open * Vec2(0.9, 0) - Vec2(3, 1.9)).norm(), kRoundoff_m);
}

}  // namespace
}  // namespace panoptes::sim

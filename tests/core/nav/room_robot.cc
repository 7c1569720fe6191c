// SPDX-License-Identifier: BSD-3-Clause
#include "tests/core/nav/room_robot.h"

#include <numbers>

#include "core/geometry/pose3.h"

namespace panoptes::test {

RoomRobot::RoomRobot(std::uint64_t seed) : rng_(seed) {
  scene_.carpet = {Vec3(120, 110, 90), 0.08, 1};
  const double high_m = 2.5;
  const auto wall = [&](const Vec2& low, const Vec2& high, const Vec3& bgr, int pattern) {
    scene_.boxes.push_back({low, high, high_m, {bgr, 0.5, pattern}});
  };
  wall({-3.2, -2.2}, {3.2, -2}, Vec3(180, 190, 200), 2);
  wall({-3.2, 2}, {3.2, 2.2}, Vec3(200, 180, 170), 3);
  wall({-3.2, -2}, {-3, 2}, Vec3(170, 200, 180), 4);
  wall({3, -2}, {3.2, 2}, Vec3(190, 170, 200), 5);
  scene_.boxes.push_back({{1.6, 0.6}, {2.2, 1.4}, 0.7, {Vec3(30, 40, 200), 0.4, 6}});

  RigCamera loop;
  loop.intrinsics = pinhole(320, 240, deg_to_rad(80));
  loop.roles = {"loop_front"};
  loop.T_body_camera = mounted_camera({0, 0, 0.79}, 0, 0);
  rig_.cameras["front"] = loop;
  loop.roles = {"loop_back"};
  loop.T_body_camera = mounted_camera({0, 0, 0.71}, deg_to_rad(180), 0);
  rig_.cameras["back"] = loop;
  rig_.cameras["floor"] = office_floor_camera();
  rig_.cameras["floor"].roles = {"floor"};
}

void RoomRobot::look_back_at_the_floor() {
  RigCamera camera = rig_.cameras.at("floor");
  camera.T_body_camera = on_floor({0, 0, std::numbers::pi}) * camera.T_body_camera;
  rig_.cameras["a-floor-behind"] = camera;  // by its name before the other
}

void RoomRobot::bend(const Distortion& distortion) {
  for (auto& [name, camera] : rig_.cameras) {
    camera.intrinsics = lens_of_view(320, 240, deg_to_rad(90), distortion);
  }
}

Observation RoomRobot::look(double at_s, const Pose2& T_scene_body, const Pose2& T_odom_body) {
  Observation seen;
  seen.stamp = time_at(at_s);
  seen.odometry.T_odom_body = T_odom_body;
  for (const auto& [name, camera] : rig_.cameras) {
    RigCamera as_it_sits = camera;
    if (const auto knock = knocks_.find(name); knock != knocks_.end()) {
      Eigen::Quaterniond& rotation = as_it_sits.T_body_camera.rotation;
      rotation = Eigen::Quaterniond(knock->second) * rotation;
    }
    seen.pictures[name] = {seen.stamp, draw(scene_, as_it_sits, T_scene_body, rng_)};
  }
  return seen;
}

}  // namespace panoptes::test

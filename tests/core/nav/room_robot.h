// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include <Eigen/Geometry>

#include "core/camera/observation.h"
#include "core/geometry/body.h"
#include "tests/support/floor_scene.h"

namespace panoptes::test {

/// A room of 6 x 4 m with patterned walls and a box in it, seen by the three cameras of the
/// office's rig from wherever the test puts the robot.
class RoomRobot {
 public:
  explicit RoomRobot(std::uint64_t seed);

  /// What it sees at `T_scene_body`, with what the wheels say.
  Observation look(double at_s, const Pose2& T_scene_body, const Pose2& T_odom_body);

  const Rig& rig() const { return rig_; }

  /// From now on it has another floor camera, which looks back.
  void look_back_at_the_floor();

  /// From now on a camera is turned so about the body's axes, which its rig file does not say.
  void knock(const std::string& camera, const Eigen::AngleAxisd& turn) { knocks_[camera] = turn; }

  /// From now on its cameras see 90 degrees through such lenses.
  void bend(const Distortion& distortion);

 private:
  Rng rng_;
  FloorScene scene_;
  Rig rig_;
  std::map<std::string, Eigen::AngleAxisd> knocks_;
};

}  // namespace panoptes::test

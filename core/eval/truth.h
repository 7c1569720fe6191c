// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/base/time.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/geometry/grid2.h"
#include "core/geometry/pose2.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// A layer of the true world over the floor, in `scene`: 1 where set; 0 outside.
using TruthLayer = Grid2<std::uint8_t>;

/// The true state at one frame set.
struct TruePose {
  Time stamp;
  Pose2 T_scene_body;
  Twist2 twist_body;
  double clearance_m = 0;  ///< from the body's outline to the nearest object
  double pitch_rad = 0;    ///< of a body that does not stay level: its nose down,
  double roll_rad = 0;     ///< its right side down,
  double heave_m = 0;      ///< and all of it lifted
};

/// What one picture truly shows, as far as it was asked for.
struct TruePicture {
  Time stamp;            ///< the picture's own
  Pose3 T_scene_camera;  ///< at that instant
  cv::Mat depth_m;       ///< float, along the camera's axis, of an equidistant lens along each
                         ///< pixel's ray; infinite where nothing is
  cv::Mat instance;      ///< 16 bit: 1 + the number of the world's object, 0 where nothing is
  cv::Mat floor_label;   ///< 8 bit: 255 where it shows what is below 2 cm
  std::map<std::string, int> object_px;  ///< how many pixels show each object, by its name
};

/// A contact of the body with something, from first touch until apart for 1 s.
struct TrueContact {
  Time stamp;
  Vec2 p_scene = Vec2::Zero();
  std::string object;
  bool while_moving = true;  ///< moving, or told to move
};

/// What the robot truly rolls on.
struct TrueWheels {
  double left_radius_m = 0;
  double right_radius_m = 0;
  double base_m = 0;  ///< between the wheels' points of contact
};
void bind(Fields& f, TrueWheels& o);

/// What the truth of a run says of the robot itself, to be kept in a file.
struct TruePlatform {
  std::optional<Rig> rig;
  std::optional<TrueWheels> wheels;
};
void bind(Fields& f, TruePlatform& o);

/// What really was, for evaluation and the recorder alone; a plain value.
struct Truth {
  std::vector<TruePose> poses;  ///< one per frame set, in order
  std::vector<TrueContact> contacts;
  TruthLayer floor;   ///< 1 cm: 1 where something stands between the floor and 2 cm above it
  TruthLayer body;    ///< 1 cm: 1 where something is between 2 cm and the top of the robot's mast
  TruthLayer seen;    ///< 5 cm: 1 where the mapped part of a floor camera saw the floor or the foot
                      ///< of a thing that stands there, unoccluded, at some frame set
  double path_m = 0;  ///< length of the true path
  /// As it was when the run began; `clock_offset_s` is what its stamps truly are too late.
  std::optional<Rig> rig = {};
  std::optional<TrueWheels> wheels = {};
};

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/calib/keyframe_bundle.h"
#include "core/calib/mono_map.h"
#include "core/calib/planar_hand_eye.h"
#include "core/calib/rig_bundle.h"
#include "core/calib/wheel_readings.h"
#include "core/camera/rig.h"

namespace panoptes {

/// One camera of a recorded drive, with the map that it has made by itself.
struct MappedCamera {
  std::string name;
  RigCamera believed;
  MonoMap map;
  AdjustedMap adjusted;
};

struct RigCalibrationOptions {
  RigBundleOptions bundle;
  std::optional<JointCovariance> known_together;  ///< Rig::covariance
  double height_sigma_m = 0.05;  ///< of cameras against each other, before anything is seen of it
  double first_search_px = 4;    ///< sigma of where another camera's points are expected at first,
  double search_px = 1.5;        ///< and when the rig has been adjusted
  double least_correlation = 0.85;  ///< of what is taken for a point
};

/// A rig as all that its cameras saw while it drove has it.
struct RigCalibration {
  std::vector<std::string> cameras;
  std::vector<std::optional<PlanarHandEye>> hand_eye;  ///< what each knew by itself,
  std::vector<std::string> by_others;  ///< and why it knew nothing: others' points alone tell of it
  std::vector<int> map_of_point;       ///< the camera whose map each point is of
  RigTracks tracks;
  RigBundleState before;  ///< as each camera knew by itself, before all were adjusted together
  RigBundle bundle;
  std::optional<JointCovariance> known_together;  ///< RigCalibrationOptions
  std::vector<int> shared;  ///< points that each camera and another one's map have in common
  WheelsKnown wheels_known;
  WheelReadings wheels;  ///< that were gone by: a camera's path where none were read
};

/// The rig file's cameras as they were found, with the sigmas that are left. What nothing has shown
/// stays, with its sigma.
Rig calibrated(const Rig& believed, const RigCalibration& calibration);

/// A picture of a camera, grey: the frame of its map.
using FramePicture = std::function<cv::Mat(std::size_t camera, std::size_t frame)>;

/// Calibrates a rig by the maps that its cameras have made, by themselves and at the same time, and
/// by its wheels (thesis 4.3.4 to 4.4, where maps are laid on each other by matches alone): how
/// each camera is mounted comes first from its path beside the wheels' (planar_hand_eye), which
/// lays all maps on each other; then every camera's points are sought in every other camera's
/// pictures, and all is adjusted together. A camera with no map that is of use (`adjusted` is
/// empty, or its path contradicts the wheels') is found by the points of others, from where the rig
/// file has it: its frames are then all of its pictures. Where no wheels were read (`wheels` is
/// empty) a camera's path stands for them (path_as_wheels), and all is told up to scale and to
/// where the body is: those stay as believed. `progress` is told the share that is done.
/// Throws HandEyeError, with a camera's name, where no camera knows anything by itself.
RigCalibration calibrate_rig(const RigCalibrationOptions& options,
                             const std::vector<MappedCamera>& cameras, const WheelReadings& wheels,
                             const FramePicture& picture,
                             const std::function<void(double)>& progress);

}  // namespace panoptes

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/calib/drive_path.h"
#include "core/calib/rig_bundle.h"
#include "core/calib/rig_calibration.h"
#include "core/camera/rig.h"

namespace panoptes {

/// What is assumed of a drive that nobody has driven yet. The defaults are what 11 calibrated roses
/// in furnished rooms of 5 to 6 m had on the mean (core/README.md).
struct PlanOptions {
  RigBundleOptions bundle;
  std::optional<JointCovariance> known_together;  ///< Rig::covariance
  /// Length, width and height of the room; it starts in the middle, along the length. A path that
  /// leaves it makes it larger.
  Vec3 room_m{5.5, 5.5, 2.6};
  double nearest_share = 0.35;  ///< of the way to a wall: furniture stands before it
  /// A camera maps new points where fewer of its own are in view; of those that are
  int points_in_view = 16;
  double own_found = 0.55;   ///< so many are found in a picture,
  double other_found = 0.7;  ///< and so many of other cameras' points.
  /// Wheels of a Pioneer, a floor as level as it shows.
  RigNoise noise{0.042, 0.050, {0.0055, 0.0005, 0.03, 0.0002, deg_to_rad(0.01)}, 0.0004};
};

/// What a calibration would tell of a rig that is as believed, and what it would leave open, after
/// a body has gone such a path: its cameras map points on walls, floor and ceiling of the assumed
/// room, and are adjusted together, without pictures. The same bits every time.
RigCalibration plan_calibration(const PlanOptions& options,
                                const std::vector<std::pair<std::string, RigCamera>>& cameras,
                                const DrivePath& path);

/// What to drive otherwise or to measure by hand, in words, for what a plan leaves open.
std::vector<std::string> plan_advice(const RigCalibration& plan);

}  // namespace panoptes

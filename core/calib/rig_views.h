// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "core/base/time.h"
#include "core/calib/rig_bundle.h"
#include "core/calib/wheel_readings.h"
#include "core/camera/rig.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// Pictures are of one instant when they were taken so little apart.
inline constexpr Duration kSameInstant = std::chrono::microseconds(1500);

/// A picture that may be of an instant.
struct TakenPicture {
  Time instant;  ///< by the odometry's clock
  std::size_t camera = 0;
  std::size_t frame = 0;
};

/// The instants of which pictures are used, and these.
struct ChosenViews {
  struct View {
    std::size_t camera = 0;
    std::size_t instant = 0;
    std::size_t frame = 0;
  };
  std::vector<Time> instants;
  std::vector<View> views;
};

/// Instants, each where one of its cameras was at most once before, and the pictures that were
/// taken then, within `same` or while the body stood: what wheels say between pictures is far less
/// true than pictures. `taken` in order of time, where wheels tell.
ChosenViews choose_views(const std::vector<TakenPicture>& taken, std::size_t cameras,
                         const WheelReadings& wheels, Duration same);

/// Where the views of a rig show a point that is of one camera's map. `T_start_camera` is of each
/// view.
std::vector<RigSeen> sightings(const std::vector<RigCamera>& rig, const std::vector<RigView>& views,
                               const std::vector<Pose3>& T_start_camera, const Vec3& p_start,
                               std::size_t point, std::size_t camera_of_point);

/// How many points each camera and another one's map have in common.
std::vector<int> shared_points(const RigTracks& tracks, const std::vector<int>& map_of_point,
                               std::size_t cameras);

}  // namespace panoptes

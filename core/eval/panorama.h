// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "core/eval/rig_sight.h"

namespace panoptes {

/// Which cameras see what of the panorama around the robot: directions from 10 degrees below the
/// horizon to straight up, by solid angle. What lies lower is floor, which looks the same in many
/// places.
struct PanoramaSight {
  static constexpr int kHeadings = 72;  ///< a whole turn
  static constexpr int kBands = 20;
  std::vector<CameraSet> seen;  ///< [band * kHeadings + heading]
};
PanoramaSight panorama_sight(const RigSight& sight);

/// Of the panorama, the share that `cameras` see both before and after the body was turned by so
/// many of kHeadings; none: the share that they see. Half of kHeadings is the opposite heading,
/// which a front and a back camera show to each other. A proxy: it says what two pictures of one
/// place can have in common, not whether it is told from others.
double common_share(const PanoramaSight& panorama, CameraSet cameras, int turned);

/// Two cameras that see the same of what is far away.
struct CameraOverlap {
  std::size_t a = 0;
  std::size_t b = 0;
  double share = 0;  ///< of the view of the narrower one, by solid angle
};

/// What the cameras see of everything far around them, by solid angle.
struct OverlapSight {
  double seen_share = 0;                ///< of all directions, by any camera
  double twice_share = 0;               ///< of all directions, by two cameras or more
  std::vector<CameraOverlap> overlaps;  ///< pairs that share any
};
OverlapSight overlap_sight(const RigSight& sight);

}  // namespace panoptes
